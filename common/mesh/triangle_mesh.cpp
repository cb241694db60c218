#include "common/mesh/triangle_mesh.hpp"

#include <bit>
#include <cstddef>
#include <limits>

namespace multitetra {

std::vector<SurfaceTriangle> triangles_of(const TriangleMesh& mesh) {
  std::vector<SurfaceTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  return triangles;
}

namespace {

// Assigns numbers to positions in order of appearance: a hash table with linear probing, at most
// half full. Equal coordinates are the same position, also 0 and -0.
class PositionNumbers {
 public:
  explicit PositionNumbers(std::size_t max_positions)
      : slots_(std::bit_ceil(2 * max_positions + 2), kNone) {}

  // Returns the number of the position, which is appended to `known` if it is new.
  std::uint32_t number(const Vec3& position, std::vector<Vec3>& known) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash(position) & mask;
    while (slots_[at] != kNone && known[slots_[at]] != position) at = (at + 1) & mask;
    if (slots_[at] == kNone) {
      slots_[at] = static_cast<std::uint32_t>(known.size());
      known.push_back(position);
    }
    return slots_[at];
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  static std::size_t hash(const Vec3& position) {
    std::uint64_t mixed = 0;
    for (const double coordinate : position) {
      mixed = (mixed ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0x9E3779B97F4A7C15u;
      mixed ^= mixed >> 29;
    }
    return static_cast<std::size_t>(mixed ^ mixed >> 32);
  }

  std::vector<std::uint32_t> slots_;
};

}  // namespace

WeldedMesh welded(const TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  WeldedMesh result;
  result.mesh.triangles.reserve(mesh.triangles.size());
  // Only vertices of triangles that stay may be numbered, so degenerate ones are found first.
  std::vector<Vec3> distinct;
  PositionNumbers numbers(mesh.vertices.size());
  std::vector<std::uint32_t> position_of(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    position_of[i] = numbers.number(mesh.vertices[i], distinct);
  }
  std::vector<std::uint32_t> number(distinct.size(), kUnused);
  for (TriangleIndices t : mesh.triangles) {
    for (std::uint32_t& corner : t) corner = position_of[corner];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++result.degenerate_triangles;
      continue;
    }
    for (std::uint32_t& corner : t) {
      if (number[corner] == kUnused) {
        number[corner] = static_cast<std::uint32_t>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(distinct[corner]);
      }
      corner = number[corner];
    }
    result.mesh.triangles.push_back(t);
  }
  return result;
}

}  // namespace multitetra
