// A digest of a set of triangles on the lattice, independent of their order and of their division
// into tiles.
//
// Each triangle hashes to 128 bits: XXH3-128, seed = lattice resolution, over its nine coordinates
// as little-endian 32-bit integers, corners in orientation order from the least (x, y, z). The
// digest is the sum of the hashes, with the two 64-bit halves added separately modulo 2^64. So the
// digests of tiles add up to that of the mesh, and encodings that differ between versions of Draco
// or protobuf do not matter. It protects against faults and damage, not against an adversary who
// constructs collisions.
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

  // Returns 32 lower-case hexadecimal digits, `high` first.
  [[nodiscard]] std::string hex() const;
  [[nodiscard]] static std::optional<ContentDigest> from_hex(std::string_view hex);
};

[[nodiscard]] ContentDigest digest(const std::array<LatticePoint, 3>& triangle, int resolution);
[[nodiscard]] ContentDigest digest(const LatticeMesh& mesh);

// Returns the digest of any bytes: XXH3-128, seed 0.
[[nodiscard]] ContentDigest digest_of_bytes(std::string_view bytes);

}  // namespace multitetra
