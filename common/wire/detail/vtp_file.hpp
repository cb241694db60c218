// VTK's XML polygonal data, for ParaView and similar programs.
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// Returns the bytes of the file: points, triangles and, if the mesh has them, the point data
// "normals", "scalars" (NaN for no value) and "colors" (red, green, blue), as raw appended bytes.
[[nodiscard]] std::string vtp_file(const PositionedMesh& mesh);

}  // namespace multitetra
