// Reads meshes of any program: PLY (text, or binary in either byte order), STL (text or binary),
// OBJ, binary glTF (also with KHR_draco_mesh_compression), Draco, and VTK's .vtp (text, base64 or
// appended, also compressed).
//
//   const WeldedMesh head = welded(read_mesh("head.glb"));
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/mesh/triangle_mesh.hpp"

namespace multitetra {

// Reads all triangles of the file, in its coordinates. Cuts polygons into triangles; ignores
// everything that is not a surface. Recognizes the format by its content if that shows it, else by
// its suffix. Applies the transforms of nodes of a glTF scene, and turns glTF's y-up to z-up. Our
// PLY, STL and OBJ files name the lattice of their vertices.
//
// The file is untrusted, and read in a sandbox: throws VolumeFileError with the file's name, the
// problem and a remedy.
[[nodiscard]] TriangleMesh read_mesh(const std::filesystem::path& file);

// The same in this process, for processes that are sandboxes.
[[nodiscard]] TriangleMesh read_mesh_here(const std::filesystem::path& file);

// Converts coordinates to the volume's unit of length where the mesh's unit is known, too, and
// another one (3MF files). Returns sentences that say so, or nothing.
[[nodiscard]] std::vector<std::string> convert_to_unit(TriangleMesh& mesh, const std::string& unit);

}  // namespace multitetra
