// STL: triangles with explicit corners, as text or binary.
#include <algorithm>
#include <string>

#include "common/base/text.hpp"
#include "common/wire/detail/mesh_bytes.hpp"

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

// Skips the name of a solid or of its end: to the end of the line, or in files of one line to the
// first facet or end, or the next solid.
void skip_name(MeshBytes& bytes, bool is_of_end) {
  constexpr std::size_t kMaxName = 4096;  // A line may be the whole file.
  const std::string_view ahead = MeshBytes(bytes).take(std::min(kMaxName, bytes.size()));
  const std::size_t length = std::min(ahead.find_first_of("\r\n"), ahead.size());
  MeshBytes words(ahead.substr(0, length));
  std::size_t begin_of_last = 0;
  std::string last;
  while (!words.is_empty()) {
    const std::string word = lower_case(words.take_word());
    const std::size_t begin = length - words.size() - word.size();
    if (last == "facet" && word == "normal") return void(bytes.take(begin_of_last));
    if (word == (is_of_end ? "solid" : "endsolid")) return void(bytes.take(begin));
    begin_of_last = begin;
    last = word;
  }
  bytes.take(length);
}

TriangleMesh read_text(MeshBytes bytes) {
  TriangleMesh mesh;
  bool has_end = false;
  std::size_t facet_began = 0;
  for (std::string word = lower_case(bytes.take_word()); !word.empty();
       word = lower_case(bytes.take_word())) {
    if (word == "vertex") {
      Vec3 place;
      for (double& coordinate : place) coordinate = bytes.take_decimal();
      add_corner(mesh, place);
    } else if (word == "facet") {
      facet_began = mesh.vertices.size();
    } else if (word == "endfacet" && mesh.vertices.size() - facet_began != 3) {
      throw MeshFileError("a facet has " + std::to_string(mesh.vertices.size() - facet_began) +
                          " corners, but those of STL are triangles");
    } else if (word == "solid" || word == "endsolid") {
      has_end = word == "endsolid";
      skip_name(bytes, has_end);
    }
  }
  if (!has_end || mesh.vertices.size() % 3 != 0) {
    throw MeshFileError("it ends too early", kGetCompleteCopy);
  }
  return mesh;
}

// Returns whether it begins with "solid", in any case and after any white space, and with a facet
// or the end soon after: headers of binary files may begin with "solid", too.
bool begins_as_text(std::string_view file) {
  constexpr std::size_t kWithin = 4096;
  const std::string beginning = lower_case(file.substr(0, kWithin));
  return MeshBytes(beginning).take_word() == "solid" &&
         (beginning.find("facet") != beginning.npos ||
          beginning.find("endsolid") != beginning.npos);
}

}  // namespace

TriangleMesh read_stl(std::string_view file) {
  const bool is_text = begins_as_text(file);
  if (file.size() >= kStlHeaderBytes + 4) {
    MeshBytes bytes(file);
    bytes.take(kStlHeaderBytes);
    const auto count = bytes.take_number<std::uint32_t>();
    // Some programs append bytes, but not those of triangles.
    const bool has_more = !is_text && count > 0 && bytes.size() > kStlTriangleBytes * count &&
                          bytes.size() < kStlTriangleBytes * (std::size_t{count} + 1);
    if (bytes.size() == kStlTriangleBytes * count || has_more) return read_binary(bytes, count);
    if (!is_text) {
      throw MeshFileError(
          "it does not begin with 'solid', as text does, and the header of binary "
          "STL declares " +
          std::to_string(count) + " triangles, but it has " + std::to_string(bytes.size()) +
          " bytes for them");
    }
  }
  if (!is_text) {
    throw MeshFileError(
        "it is neither text STL, which begins with 'solid' and has facets, nor "
        "binary STL, which has at least 84 bytes");
  }
  return read_text(MeshBytes(file));
}

}  // namespace multitetra
