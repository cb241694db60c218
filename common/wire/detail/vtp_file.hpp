// VTK's XML polygonal data, for ParaView and its kin.
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// The whole file's bytes: points and triangles and, where the mesh has them, the point data
// "normals", "scalars" (NaN for no value) and "colors" (red, green, blue), as raw appended bytes.
[[nodiscard]] std::string vtp_file(const PositionedMesh& mesh);

}  // namespace multitetra
