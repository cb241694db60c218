#include "server/certify/clipped_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>

namespace multitetra {
namespace {

using Polygon = std::vector<Vec3>;

// A plane of the box: the inside is where inside(place) >= 0, for places in the world.
struct Face {
  Vec3 normal = {};
  double offset = 0;

  [[nodiscard]] double inside(const Vec3& place) const { return dot(normal, place) + offset; }
};

std::array<Face, 6> faces_of(const PlacedBox& placed) {
  const Affine& map = placed.world_to_box;
  std::array<Face, 6> faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 row = {map.columns[0][axis], map.columns[1][axis], map.columns[2][axis]};
    const double origin = map.translation[axis];
    faces[2 * axis] = {.normal = row, .offset = origin - placed.box.low[axis]};
    faces[2 * axis + 1] = {.normal = scaled(row, -1), .offset = placed.box.high[axis] - origin};
  }
  return faces;
}

Polygon cut(const Polygon& polygon, const Face& face) {
  Polygon rest;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& from = polygon[i];
    const Vec3& to = polygon[(i + 1) % polygon.size()];
    const double before = face.inside(from);
    const double after = face.inside(to);
    if (before >= 0) rest.push_back(from);
    if ((before >= 0) == (after >= 0)) continue;
    rest.push_back(moved(from, before / (before - after), difference(to, from)));
  }
  return rest;
}

// Collects triangles and their vertices.
class Part {
 public:
  explicit Part(const TriangleMesh& whole) : whole_(whole), copies_(whole.vertices.size(), kNone) {}

  void add(const TriangleIndices& triangle) {
    TriangleIndices copy{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& at = copies_[triangle[i]];
      if (at == kNone) at = add(whole_.vertices[triangle[i]]);
      copy[i] = at;
    }
    mesh.triangles.push_back(copy);
  }

  void add(const Polygon& polygon) {
    if (polygon.size() < 3) return;
    const std::uint32_t first = add(polygon[0]);
    std::uint32_t before = add(polygon[1]);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const std::uint32_t last = add(polygon[i]);
      mesh.triangles.push_back({first, before, last});
      before = last;
    }
  }

  TriangleMesh mesh;

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t add(const Vec3& vertex) {
    mesh.vertices.push_back(vertex);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  }

  const TriangleMesh& whole_;
  std::vector<std::uint32_t> copies_;  // Of the vertices of uncut triangles.
};

}  // namespace

TriangleMesh clipped(const TriangleMesh& mesh, const PlacedBox& box) {
  const std::array<Face, 6> faces = faces_of(box);
  Part part(mesh);
  for (const TriangleIndices& triangle : mesh.triangles) {
    const Polygon corners = {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                             mesh.vertices[triangle[2]]};
    Polygon rest = corners;
    for (const Face& face : faces) rest = cut(rest, face);
    if (rest == corners) {
      part.add(triangle);
    } else {
      part.add(rest);
    }
  }
  return std::move(part.mesh);
}

}  // namespace multitetra
