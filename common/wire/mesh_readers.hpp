// Reads mesh files of any program from memory: PLY (text, or binary in either byte order), STL
// (text or binary), OBJ, binary glTF (also with KHR_draco_mesh_compression or
// EXT_meshopt_compression) and Draco.
//
// Files are untrusted: all functions throw MeshFileError, whose text says what is wrong.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/triangle_mesh.hpp"

namespace multitetra {

class MeshFileError : public std::runtime_error {
 public:
  explicit MeshFileError(const std::string& what) : std::runtime_error(what) {}
};

// Read all triangles, in the file's coordinates. Cut polygons into fans; ignore everything that is
// not a surface.
[[nodiscard]] TriangleMesh read_ply(std::string_view file);
[[nodiscard]] TriangleMesh read_stl(std::string_view file);
[[nodiscard]] TriangleMesh read_obj(std::string_view file);
// Applies the transforms of nodes, and turns glTF's y-up to z-up. `first_triangles` receives the
// index of the first triangle of each node with a mesh, unless it is null.
[[nodiscard]] TriangleMesh read_glb(std::string_view file,
                                    std::vector<std::size_t>* first_triangles = nullptr);
// Decodes in a child process, because Draco data may announce any size.
[[nodiscard]] TriangleMesh read_draco(std::string_view file);

}  // namespace multitetra
