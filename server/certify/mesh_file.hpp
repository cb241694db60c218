// Meshes in, from the files of any program: PLY (as text or binary of either byte order), STL (text
// or binary), OBJ, binary glTF (also with KHR_draco_mesh_compression), Draco's own, and VTK's .vtp
// (as text, base64 or appended, also compressed).
//
//   const WeldedMesh head = welded(read_mesh("head.glb"));
#pragma once

#include <filesystem>

#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// Reads all triangles of the file, in its coordinates. Polygons are cut into fans; everything that
// is not a surface is ignored. The format is recognized by its signature if it has one, else by its
// suffix. The nodes of a glTF scene are placed by their transforms and turned from glTF's y-up to
// z-up. PLY, STL and OBJ files of ours name the lattice of their vertices.
//
// The file is untrusted: throws VolumeFileError with the file's name, the fault and a remedy.
[[nodiscard]] TriangleMesh read_mesh(const std::filesystem::path& file);

}  // namespace multitetra
