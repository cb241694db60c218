// STL: triangles with explicit corners, as text or binary.
#include "server/certify/detail/mesh_bytes.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kStlHeaderBytes = 80;
constexpr std::size_t kStlTriangleBytes = 50;

void add_corner(TriangleMesh& mesh, const Vec3& place) {
  mesh.vertices.push_back(place);
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  if (count % 3 == 0) mesh.triangles.push_back({count - 3, count - 2, count - 1});
}

TriangleMesh read_binary(MeshBytes bytes, std::uint32_t count) {
  TriangleMesh mesh;
  if (count > 0xFFFFFFFF / 3) throw MeshFileError("it has more than 2^32 corners");
  mesh.vertices.reserve(3 * std::size_t{count});
  mesh.triangles.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    MeshBytes triangle(bytes.take(kStlTriangleBytes));
    triangle.take(12);  // The normal.
    for (int corner = 0; corner < 3; ++corner) {
      Vec3 place;
      for (double& coordinate : place) {
        coordinate = static_cast<double>(triangle.take_number<float>());
      }
      add_corner(mesh, place);
    }
  }
  return mesh;
}

TriangleMesh read_text(MeshBytes bytes) {
  TriangleMesh mesh;
  bool has_end = false;
  bytes.take_line();  // "solid" and a name.
  while (!bytes.is_empty()) {
    MeshBytes line(bytes.take_line());
    const std::string_view word = line.take_word();
    if (word == "endsolid") has_end = true;
    if (word != "vertex") continue;
    Vec3 place;
    for (double& coordinate : place) coordinate = line.take_decimal();
    add_corner(mesh, place);
  }
  if (!has_end || mesh.vertices.size() % 3 != 0) throw MeshFileError("it ends too early");
  return mesh;
}

}  // namespace

TriangleMesh read_stl(std::string_view file) {
  // Binary files may begin with "solid" too, but their length then matches the number of triangles.
  if (file.size() >= kStlHeaderBytes + 4) {
    MeshBytes bytes(file);
    bytes.take(kStlHeaderBytes);
    const auto count = bytes.take_number<std::uint32_t>();
    if (bytes.size() == kStlTriangleBytes * count) return read_binary(bytes, count);
    if (!file.starts_with("solid")) {
      throw MeshFileError("its header promises " + std::to_string(count) +
                          " triangles and it has " + std::to_string(bytes.size()) +
                          " bytes for them");
    }
  }
  if (!file.starts_with("solid")) throw MeshFileError("it is neither text nor binary STL");
  return read_text(MeshBytes(file));
}

}  // namespace multitetra
