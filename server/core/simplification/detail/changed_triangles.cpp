#include "server/core/simplification/detail/changed_triangles.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/mesh/lattice_plane.hpp"
#include "common/mesh/triangle_tree.hpp"
#include "server/core/simplification/detail/star_projection.hpp"

namespace multitetra {
namespace {

constexpr TriangleIndices kRemoved = {CollapsingMesh::kNone, CollapsingMesh::kNone,
                                      CollapsingMesh::kNone};

// Finds, on demand, the vertices around which no two triangles can intersect.
class ClearStars {
 public:
  // `turns` are those of the mesh's triangles.
  ClearStars(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices,
             std::span<const OrientationMask> turns)
      : mesh_(mesh), vertices_(vertices), turns_(turns), known_(vertices.size(), kUnknown) {}

  [[nodiscard]] bool has_disjoint_star(std::uint32_t vertex) {
    if (known_[vertex] == kUnknown) known_[vertex] = find(vertex) ? kClear : kUnclear;
    return known_[vertex] == kClear;
  }

 private:
  enum Known : std::uint8_t { kUnknown, kClear, kUnclear };

  [[nodiscard]] bool find(std::uint32_t vertex) {
    if (mesh_.kind(vertex) != CollapsingMesh::VertexKind::kInner) return false;
    mesh_.ring(vertex, ring_);
    OrientationMask all;
    for (const std::uint32_t corner : ring_)
      all.intersect(turns_[CollapsingMesh::triangle_of(corner)]);
    if (!all.any()) return false;
    around_.clear();
    for (const std::uint32_t corner : ring_) {
      around_.push_back(vertices_[mesh_.vertex(CollapsingMesh::next(corner))]);
    }
    return winds_once(vertices_[vertex], around_, all);
  }

  const CollapsingMesh& mesh_;
  std::span<const LatticePoint> vertices_;
  std::span<const OrientationMask> turns_;
  std::vector<Known> known_;
  std::vector<std::uint32_t> ring_;
  std::vector<LatticePoint> around_;
};

bool has_corner(const TriangleIndices& triangle, std::uint32_t vertex) {
  return triangle[0] == vertex || triangle[1] == vertex || triangle[2] == vertex;
}

}  // namespace

std::vector<std::uint8_t> ChangedTriangles::intersecting_corners(const CollapsingMesh& mesh) {
  std::vector<TriangleIndices> left;
  std::vector<std::uint8_t> is_changed;
  std::vector<LatticePlane> planes;
  std::vector<TriangleBox> boxes;
  std::vector<OrientationMask> turns(mesh.triangle_count());
  const auto add = [&](const LatticeTriangle& triangle) {
    planes.emplace_back(triangle);
    boxes.push_back(box_of(triangle));
  };
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleIndices now = mesh.is_removed(t) ? kRemoved : mesh.triangle(t);
    const bool is_new = std::exchange(known_[t], now) != now;
    if (mesh.is_removed(t)) continue;
    left.push_back(now);
    is_changed.push_back(is_new ? 1 : 0);
    add(placed(now));
    turns[t] = OrientationMask(planes.back().normal());
  }
  for (const LatticeTriangle& triangle : obstacles_) add(triangle);
  const TriangleTree tree(boxes);
  ClearStars stars(mesh, vertices_, turns);
  std::vector<std::uint8_t> is_corner;
  const auto mark = [&](std::uint32_t index) {
    is_corner.resize(vertices_.size(), 0);
    for (const std::uint32_t v : left[index]) is_corner[v] = 1;
  };
  for (std::uint32_t one = 0; one < left.size(); ++one) {
    if (is_changed[one] == 0) continue;
    tree.visit_near(boxes[one], [&](std::uint32_t other) {
      const bool is_obstacle = other >= left.size();
      if (other == one || (!is_obstacle && other < one && is_changed[other] != 0)) return false;
      if (!is_obstacle) {
        for (const std::uint32_t v : left[one]) {
          if (has_corner(left[other], v) && stars.has_disjoint_star(v)) return false;
        }
      }
      if (!intersect(planes[one], planes[other])) return false;
      mark(one);
      if (!is_obstacle) mark(other);
      return false;
    });
  }
  return is_corner;
}

}  // namespace multitetra
