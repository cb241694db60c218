// Helpers of the mesh file readers.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/base/text.hpp"
#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// An error in a mesh file. read_mesh() adds the file's name.
class MeshFileError : public std::runtime_error {
 public:
  explicit MeshFileError(const std::string& what) : std::runtime_error(what) {}
};

// The most vertices of a mesh, and the most triangles.
inline constexpr std::size_t kMaxMeshElements = std::size_t{1} << 28;
// The most corners of a polygon.
inline constexpr std::size_t kMaxPolygonCorners = 65'536;

// Appends polygons as triangle fans around their first corner.
class PolygonSink {
 public:
  explicit PolygonSink(TriangleMesh& mesh) : mesh_(mesh) {}

  void begin() { count_ = 0; }
  // Adds a corner. `vertex` comes unchecked from the file; throws MeshFileError if it is out of
  // range.
  void add(std::int64_t vertex) {
    if (vertex < 0 || vertex >= static_cast<std::int64_t>(mesh_.vertices.size())) {
      throw MeshFileError("a face has the vertex " + std::to_string(vertex) + " of " +
                          std::to_string(mesh_.vertices.size()));
    }
    if (count_ >= kMaxPolygonCorners) {
      throw MeshFileError("a face has more than " + std::to_string(kMaxPolygonCorners) +
                          " corners");
    }
    const auto corner = static_cast<std::uint32_t>(vertex);
    if (count_ == 0) first_ = corner;
    if (count_ >= 2) mesh_.triangles.push_back({first_, last_, corner});
    last_ = corner;
    ++count_;
  }

 private:
  TriangleMesh& mesh_;
  std::size_t count_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t last_ = 0;
};

// Reads numbers and words from text or bytes; throws MeshFileError if they end too early.
class MeshBytes {
 public:
  explicit MeshBytes(std::string_view rest) : rest_(rest) {}

  [[nodiscard]] std::size_t size() const { return rest_.size(); }
  [[nodiscard]] bool is_empty() const { return rest_.empty(); }

  std::string_view take(std::size_t bytes) {
    if (bytes > rest_.size()) throw MeshFileError("it ends too early");
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }
  template <typename Number>
  Number take_number(bool is_big_endian = false) {
    std::string bytes(take(sizeof(Number)));
    if (is_big_endian) bytes = std::string(bytes.rbegin(), bytes.rend());
    Number number;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  // Returns the text up to the end of the line, which is skipped; empty at the end.
  std::string_view take_line() { return multitetra::take_line(rest_); }
  // Returns the next word between white space, across lines; empty at the end.
  std::string_view take_word();
  // Reads a word that must be a number.
  double take_decimal();

 private:
  std::string_view rest_;
};
static_assert(std::endian::native == std::endian::little);

// Throw MeshFileError unless the whole word is a number.
[[nodiscard]] double decimal_from(std::string_view word);
[[nodiscard]] std::int64_t integer_from(std::string_view word);

[[nodiscard]] TriangleMesh read_ply(std::string_view file);
[[nodiscard]] TriangleMesh read_stl(std::string_view file);
[[nodiscard]] TriangleMesh read_obj(std::string_view file);
[[nodiscard]] TriangleMesh read_glb(std::string_view file);
[[nodiscard]] TriangleMesh read_draco(std::string_view file);

}  // namespace multitetra
