// OBJ: lines with vertices, and with faces that number them from 1, or backward from the last one.
#include "common/wire/detail/mesh_bytes.hpp"

namespace multitetra {
namespace {

enum class Statement { kVertex, kFace, kOther };

Statement statement_of(std::string_view line) {
  const std::string_view word = MeshBytes(line).take_word();
  if (word == "v" || word == "V") return Statement::kVertex;
  if (word == "f" || word == "F" || word == "fo") return Statement::kFace;  // "fo" is obsolete.
  if (word == "surf" || word == "curv" || word == "bsp" || word == "bzp" || word == "call") {
    throw MeshFileError("it has free-form surfaces or other files ('" + std::string(word) +
                        "'), which are not read");
  }
  return Statement::kOther;
}

// Returns a line that ends in a backslash with the lines that continue it.
std::string with_continuation(std::string_view line, MeshBytes& bytes) {
  std::string whole(line);
  while (whole.ends_with('\\')) {
    whole.back() = ' ';
    whole += bytes.take_text_line();
  }
  return whole;
}

}  // namespace

TriangleMesh read_obj(std::string_view file) {
  TriangleMesh mesh;
  PolygonSink polygon(mesh);
  MeshBytes bytes(file);
  std::string continued;
  while (!bytes.is_empty()) {
    std::string_view text = bytes.take_text_line();
    const Statement statement = statement_of(text);
    if (statement != Statement::kOther && text.ends_with('\\')) {
      text = continued = with_continuation(text, bytes);
    }
    MeshBytes line(text);
    line.take_word();
    if (statement == Statement::kVertex) {
      Vec3 place;
      for (double& coordinate : place) coordinate = line.take_decimal();
      mesh.vertices.push_back(place);
    } else if (statement == Statement::kFace) {
      polygon.begin();
      for (std::string_view corner = line.take_word(); !corner.empty(); corner = line.take_word()) {
        const std::int64_t number = integer_from(corner.substr(0, corner.find('/')));
        const auto count = static_cast<std::int64_t>(mesh.vertices.size());
        polygon.add(number < 0 ? count + number : number - 1);
      }
      polygon.end();
    }
  }
  if (mesh.vertices.empty()) throw MeshFileError("it has no vertices");
  return mesh;
}

}  // namespace multitetra
