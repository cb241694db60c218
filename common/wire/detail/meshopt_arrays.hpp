// The arrays of meshes for EXT_meshopt_compression, by meshoptimizer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// Returns the mesh with triangles and vertices in the order in which they compress best, without
// unused vertices. Requires triangles.
[[nodiscard]] PositionedMesh in_compressible_order(const PositionedMesh& mesh);

// Positions as multiples of one step above a corner of their box.
struct PositionSteps {
  Vec3 low = {};
  double step = 0;
  // The fourth is 0.
  std::vector<std::array<std::uint16_t, 4>> steps;
};

// Rounds positions to 1 / 65535 of the longest side of their box, by at most
// position_rounding(). Returns nullopt if two of them would coincide.
[[nodiscard]] std::optional<PositionSteps> position_steps(const PositionedMesh& mesh);

// Returns unit vectors for the filter OCTAHEDRAL, with 8 bits each.
[[nodiscard]] std::vector<std::array<std::int8_t, 4>> octahedral(
    std::span<const UnitVector> vectors);

// Compress elements of `stride` bytes, a multiple of 4, and triangles of `vertices` vertices.
[[nodiscard]] std::string meshopt_attributes(std::span<const std::byte> elements,
                                             std::size_t stride);
[[nodiscard]] std::string meshopt_triangles(std::span<const TriangleIndices> triangles,
                                            std::size_t vertices);

}  // namespace multitetra
