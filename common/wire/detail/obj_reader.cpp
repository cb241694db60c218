// OBJ: lines with vertices, and with faces that number them from 1, or backward from the last one.
#include "common/wire/detail/mesh_bytes.hpp"

namespace multitetra {

TriangleMesh read_obj(std::string_view file) {
  TriangleMesh mesh;
  PolygonSink polygon(mesh);
  MeshBytes bytes(file);
  while (!bytes.is_empty()) {
    const std::string_view text = bytes.take_line();
    if (text.ends_with('\\'))
      throw MeshFileError("it has a continued line, which is not supported");
    MeshBytes line(text);
    const std::string_view word = line.take_word();
    if (word == "v") {
      Vec3 place;
      for (double& coordinate : place) coordinate = line.take_decimal();
      mesh.vertices.push_back(place);
    } else if (word == "f") {
      polygon.begin();
      for (std::string_view corner = line.take_word(); !corner.empty(); corner = line.take_word()) {
        const std::int64_t number = integer_from(corner.substr(0, corner.find('/')));
        const auto count = static_cast<std::int64_t>(mesh.vertices.size());
        polygon.add(number < 0 ? count + number : number - 1);
      }
    }
  }
  if (mesh.vertices.empty()) throw MeshFileError("it has no vertices");
  return mesh;
}

}  // namespace multitetra
