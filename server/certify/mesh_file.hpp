// Meshes in, from the files of any program: PLY (as text or binary of either byte order), STL (text
// or binary), OBJ, binary glTF (also with KHR_draco_mesh_compression), Draco's own, and VTK's .vtp
// (as text, base64 or appended, also compressed).
//
//   const WeldedMesh head = welded(read_mesh("head.glb"));
#pragma once

#include <filesystem>

#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// All triangles in the file, in its coordinates; polygons are cut into fans, and everything that is
// no surface is left out. The format is recognized by content where it has a mark, else by suffix.
// Of glTF the nodes of the scene are taken where they stand, turned from glTF's y-up to z-up, as
// our own files are meant.
//
// No byte of the file is trusted: throws VolumeFileError, which names the file, what is wrong with
// it and a remedy.
[[nodiscard]] TriangleMesh read_mesh(const std::filesystem::path& file);

}  // namespace multitetra
