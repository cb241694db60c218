// VTK's XML polygonal data.
#pragma once

#include <filesystem>

#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// Its polygons and triangle strips; vertices and lines are left out. Throws MeshFault or
// VolumeFileError.
[[nodiscard]] TriangleMesh read_vtp(const std::filesystem::path& file);

}  // namespace multitetra
