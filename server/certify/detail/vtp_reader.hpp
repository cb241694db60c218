// VTK's XML polygonal data.
#pragma once

#include <filesystem>

#include "common/mesh/triangle_mesh.hpp"

namespace multitetra {

// Reads polygons and triangle strips; ignores vertices and lines. Throws MeshFileError or
// VolumeFileError.
[[nodiscard]] TriangleMesh read_vtp(const std::filesystem::path& file);

}  // namespace multitetra
