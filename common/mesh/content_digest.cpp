#include "common/mesh/content_digest.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdio>

#define XXH_INLINE_ALL
// Its default reads integers through pointers to longer ones: undefined where it is inlined, and
// wrong with GCC 14.
#define XXH_FORCE_MEMORY_ACCESS 0  // memcpy
#include <xxhash.h>

#include "common/mesh/mesh.hpp"

namespace multitetra {

static_assert(std::endian::native == std::endian::little,
              "The digest is defined over little-endian integers.");

std::string ContentDigest::hex() const {
  std::array<char, 33> text{};
  std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(high),
                static_cast<unsigned long long>(low));
  return text.data();
}

std::optional<ContentDigest> ContentDigest::from_hex(std::string_view hex) {
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (hex.size() != 32 || !std::all_of(hex.begin(), hex.end(), is_digit)) return std::nullopt;
  ContentDigest digest;
  std::from_chars(hex.data(), hex.data() + 16, digest.high, 16);
  std::from_chars(hex.data() + 16, hex.data() + 32, digest.low, 16);
  return digest;
}

ContentDigest digest(const std::array<LatticePoint, 3>& triangle, int resolution) {
  static_assert(sizeof(LatticePoint) == 3 * sizeof(std::int32_t));
  const auto& [a, b, c] = triangle;
  const std::array<LatticePoint, 5> around = {a, b, c, a, b};
  const std::size_t first = a < b ? (a < c ? 0 : 2) : (b < c ? 1 : 2);
  const XXH128_hash_t hash = XXH3_128bits_withSeed(&around[first], 3 * sizeof(LatticePoint),
                                                   static_cast<XXH64_hash_t>(resolution));
  return {hash.high64, hash.low64};
}

ContentDigest digest(const LatticeMesh& mesh) {
  ContentDigest sum;
  for (const auto& triangle : mesh.triangles) {
    sum +=
        digest({mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]},
               mesh.resolution);
  }
  return sum;
}

ContentDigest digest_of_bytes(std::string_view bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return {hash.high64, hash.low64};
}

}  // namespace multitetra
