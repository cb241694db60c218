// VTK's XML polygonal data, for ParaView and similar programs.
#pragma once

#include <string>
#include <string_view>

#include "common/mesh/mesh.hpp"
#include "common/mesh/triangle_mesh.hpp"

namespace multitetra {

// Returns the bytes of the file: points, triangles and, if the mesh has them, the point data
// "normals", "scalars" (NaN for no value) and "colors" (red, green, blue), as raw appended bytes.
[[nodiscard]] std::string vtp_file(const PositionedMesh& mesh);

// Reads the points and triangles of such a file. Throws std::runtime_error if it is another one.
[[nodiscard]] TriangleMesh read_own_vtp(std::string_view file);

}  // namespace multitetra
