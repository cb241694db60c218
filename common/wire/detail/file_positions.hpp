// The coordinates that mesh files store: 32-bit floats where these move no vertex noticeably.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// Returns the lowest and highest corner of the box around positions, of which there must be one.
[[nodiscard]] std::pair<Vec3, Vec3> position_bounds(const std::vector<Vec3>& positions);

// Returns the positions relative to `origin` as floats.
[[nodiscard]] std::vector<std::array<float, 3>> float_positions(const PositionedMesh& mesh,
                                                                const Vec3& origin = {0, 0, 0});
// Returns whether no coordinate of these moves by more than the mesh's limit.
[[nodiscard]] bool fits_in_floats(const PositionedMesh& mesh, const Vec3& origin = {0, 0, 0});

// Throws MeshCoordinatesError unless fits_in_floats(). `format` is for its text: "STL".
void require_floats(const PositionedMesh& mesh, const char* format, const Vec3& origin = {0, 0, 0});
[[noreturn]] void refuse_coordinates(const PositionedMesh& mesh, const char* format,
                                     double displacement);

// Returns 0 where floats fit, else the center of the positions' box.
[[nodiscard]] Vec3 origin_for_floats(const PositionedMesh& mesh);

}  // namespace multitetra
