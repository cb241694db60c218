// Reads mesh files of any program from memory: PLY (text, or binary in either byte order), STL
// (text or binary), OBJ, binary glTF (also with KHR_draco_mesh_compression or
// EXT_meshopt_compression), 3MF and Draco.
//
// Files are untrusted: all functions throw MeshFileError, which says what is wrong and what helps.
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
  explicit MeshFileError(const std::string& what,
                         const char* remedy = "Save it as PLY with triangles alone")
      : std::runtime_error(what), remedy_(remedy) {}
  [[nodiscard]] const char* remedy() const { return remedy_; }

 private:
  const char* remedy_;
};

// The remedy for a file that is shorter than it says.
inline constexpr const char* kGetCompleteCopy = "Get a complete copy of the file";

// The most vertices of a mesh, and the most triangles.
inline constexpr std::size_t kMaxMeshElements = std::size_t{1} << 28;
// The most corners of a polygon.
inline constexpr std::size_t kMaxPolygonCorners = 65'536;

// Read all triangles, in the file's coordinates. Cut polygons into triangles (see
// polygon_sink.hpp); ignore everything that is not a surface.
[[nodiscard]] TriangleMesh read_ply(std::string_view file);
[[nodiscard]] TriangleMesh read_stl(std::string_view file);
[[nodiscard]] TriangleMesh read_obj(std::string_view file);
// Applies the transforms of nodes, and turns glTF's y-up to z-up. `first_triangles` receives the
// index of the first triangle of each node with a mesh, unless it is null.
[[nodiscard]] TriangleMesh read_glb(std::string_view file,
                                    std::vector<std::size_t>* first_triangles = nullptr);
// Returns the text of the model inside a 3MF file.
[[nodiscard]] std::string three_mf_model(std::string_view file);
// Reads the objects to be built, in their places and the model's unit, from that text; their
// components are not supported. `first_triangles` is as for read_glb().
[[nodiscard]] TriangleMesh read_three_mf_model(std::string_view model,
                                               std::vector<std::size_t>* first_triangles = nullptr);
// Draco data may announce any size: limit the memory of the process for untrusted files.
[[nodiscard]] TriangleMesh read_draco(std::string_view file);

}  // namespace multitetra
