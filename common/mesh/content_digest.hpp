// A digest of a set of triangles on the lattice, independent of their order and of how they are cut
// into tiles.
//
// Each triangle hashes to 128 bits: XXH3-128, seed = lattice resolution, over its nine coordinates
// as little-endian 32-bit integers, corners in orientation order starting at the smallest (x, y,
// z). The digest is the sum of the hashes, the two 64-bit halves added separately modulo 2^64. So
// digests of tiles add up to the digest of the mesh, and neither Draco's nor protobuf's bytes,
// which differ between versions, take part. It protects against mistakes and damage, not against an
// adversary that constructs collisions.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/lattice.hpp"

namespace multitetra {

struct LatticeMesh;

struct ContentDigest {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  friend constexpr auto operator<=>(const ContentDigest&, const ContentDigest&) = default;
  constexpr ContentDigest& operator+=(const ContentDigest& other) {
    high += other.high;
    low += other.low;
    return *this;
  }

  // 32 lower-case hexadecimal digits, `high` first.
  [[nodiscard]] std::string hex() const;
  [[nodiscard]] static std::optional<ContentDigest> from_hex(std::string_view hex);
};

[[nodiscard]] ContentDigest digest(const std::array<LatticePoint, 3>& triangle, int resolution);
[[nodiscard]] ContentDigest digest(const LatticeMesh& mesh);

// The digest of any bytes: XXH3-128, seed 0.
[[nodiscard]] ContentDigest digest_of_bytes(std::string_view bytes);

}  // namespace multitetra
