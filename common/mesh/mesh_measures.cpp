#include "common/mesh/mesh_measures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/mesh/box_tree.hpp"

namespace multitetra {
namespace {

// Holds sums of 64-bit numbers.
__extension__ using Wide = __int128;

// Returns six times the signed volume of the tetrahedron formed by the triangle and the origin.
// Lattice coordinates have 20 bits, so each of the six products has 60.
std::int64_t six_times_volume(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const auto product = [](std::int64_t x, std::int64_t y) { return x * y; };
  return a.x * (product(b.y, c.z) - product(b.z, c.y)) -
         a.y * (product(b.x, c.z) - product(b.z, c.x)) +
         a.z * (product(b.x, c.y) - product(b.y, c.x));
}

// An edge of a triangle, seen from it.
struct EdgeSide {
  std::uint64_t edge;  // The lower vertex in the upper half, the higher one in the lower half.
  std::uint32_t triangle;
  std::uint32_t opposite;  // The third vertex.
  bool is_upwards;         // It runs from the lower vertex to the higher one.
};

std::vector<EdgeSide> sorted_edges(const LatticeMesh& mesh) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t number = 0; number < mesh.triangles.size(); ++number) {
    const TriangleIndices& t = mesh.triangles[number];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i];
      const std::uint32_t to = t[(i + 1) % 3];
      sides.push_back({.edge = std::uint64_t{std::min(from, to)} << 32 | std::max(from, to),
                       .triangle = number,
                       .opposite = t[(i + 2) % 3],
                       .is_upwards = from < to});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const EdgeSide& a, const EdgeSide& b) { return a.edge < b.edge; });
  return sides;
}

// Adds the bends of all edges to their components, and returns for each whether it has a border: an
// edge without an opposite one.
template <typename Side>
std::vector<bool> add_bends(const LatticeMesh& mesh, const MeshComponents& components,
                            const Side& side, bool is_mirrored,
                            std::vector<SurfaceMeasures>& measures) {
  const std::vector<EdgeSide> sides = sorted_edges(mesh);
  const auto normal = [&](std::uint32_t triangle) {
    const TriangleIndices& t = mesh.triangles[triangle];
    return cross(side(mesh.vertices[t[0]], mesh.vertices[t[1]]),
                 side(mesh.vertices[t[0]], mesh.vertices[t[2]]));
  };
  std::vector<bool> have_border(measures.size(), false);
  for (auto first = sides.begin(); first != sides.end();) {
    const auto end = std::find_if(first, sides.end(),
                                  [&](const EdgeSide& one) { return one.edge != first->edge; });
    const auto lower = static_cast<std::uint32_t>(first->edge >> 32);
    const auto upper = static_cast<std::uint32_t>(first->edge & 0xFFFFFFFF);
    const std::uint32_t component = components.of_vertex[lower];
    const bool has_up = std::any_of(first, end, [](const auto& one) { return one.is_upwards; });
    const bool has_down = std::any_of(first, end, [](const auto& one) { return !one.is_upwards; });
    if (!has_up || !has_down) have_border[component] = true;
    if (end - first == 2) {
      const Vec3 here = normal(first->triangle);
      const Vec3 there = normal((first + 1)->triangle);
      const double angle = std::atan2(length(cross(here, there)), dot(here, there));
      const Vec3 along = side(mesh.vertices[lower], mesh.vertices[upper]);
      const Vec3 across = side(mesh.vertices[lower], mesh.vertices[(first + 1)->opposite]);
      double& bend = (dot(here, across) < 0) != is_mirrored ? measures[component].convex_bend
                                                            : measures[component].concave_bend;
      bend += angle * length(along);
    }
    first = end;
  }
  return have_border;
}

}  // namespace

std::vector<SurfaceMeasures> measures_of(const LatticeMesh& mesh, const MeshComponents& components,
                                         const Affine& grid_to_world) {
  std::vector<SurfaceMeasures> measures(components.diagonals.size());
  std::vector<Wide> six_times(components.diagonals.size(), 0);
  // Applies only the linear part: the position of the world's origin does not matter.
  const double step = std::ldexp(1.0, -mesh.resolution);
  const auto side = [&](const LatticePoint& from, const LatticePoint& to) {
    const Vec3 v = {step * (to.x - from.x), step * (to.y - from.y), step * (to.z - from.z)};
    return difference(grid_to_world(v), grid_to_world.translation);
  };
  for (const TriangleIndices& t : mesh.triangles) {
    const LatticePoint& a = mesh.vertices[t[0]];
    const LatticePoint& b = mesh.vertices[t[1]];
    const LatticePoint& c = mesh.vertices[t[2]];
    const std::uint32_t component = components.of_vertex[t[0]];
    measures[component].area += 0.5 * length(cross(side(a, b), side(a, c)));
    six_times[component] += six_times_volume(a, b, c);
  }
  const std::vector<bool> have_border =
      add_bends(mesh, components, side, grid_to_world.determinant() < 0, measures);
  for (const std::uint32_t component : components.of_vertex) ++measures[component].vertices;
  // A mirroring map also reverses triangles, so the inside stays the inside.
  const double scale = std::abs(grid_to_world.determinant()) * step * step * step / 6;
  for (std::size_t i = 0; i < measures.size(); ++i) {
    if (!have_border[i]) measures[i].volume = scale * static_cast<double>(six_times[i]);
  }
  return measures;
}

double volume_bound(const SurfaceMeasures& measures, double distance) {
  const double bend = std::max(measures.convex_bend, measures.concave_bend);
  const double corners = 2 * std::numbers::pi / 3 * static_cast<double>(measures.vertices);
  return distance * (measures.area + distance * (bend / 2 + distance * corners));
}

SurfaceMeasures sum_of(const std::vector<SurfaceMeasures>& measures) {
  SurfaceMeasures all{.area = 0, .volume = 0.0};
  for (const SurfaceMeasures& one : measures) {
    all.area += one.area;
    all.convex_bend += one.convex_bend;
    all.concave_bend += one.concave_bend;
    all.vertices += one.vertices;
    all.volume = all.volume && one.volume ? std::optional(*all.volume + *one.volume) : std::nullopt;
  }
  return all;
}

SurfaceMeasures measures_from(const LatticeMesh& mesh, double min_diagonal,
                              const Affine& grid_to_world) {
  const MeshComponents components = components_of(mesh);
  const std::vector<SurfaceMeasures> all = measures_of(mesh, components, grid_to_world);
  const double shortest = components.least(min_diagonal);
  std::vector<SurfaceMeasures> written;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (components.diagonals[i] >= shortest) written.push_back(all[i]);
  }
  return sum_of(written);
}

FilledCavities filled_cavities(const LatticeMesh& mesh, const MeshComponents& components,
                               double min_diagonal, const Affine& grid_to_world) {
  const LatticeMesh removed = without_components(mesh, components, min_diagonal);
  const MeshComponents parts = components_of(removed);
  const std::vector<SurfaceMeasures> measures = measures_of(removed, parts, grid_to_world);
  std::vector<Box3> boxes(measures.size());
  for (std::size_t v = 0; v < removed.vertices.size(); ++v) {
    const LatticePoint& p = removed.vertices[v];
    boxes[parts.of_vertex[v]].add(
        Vec3{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
  }
  const BoxTree tree(boxes);
  FilledCavities filled;
  for (std::size_t i = 0; i < measures.size(); ++i) {
    if (measures[i].volume.value_or(0) >= 0) continue;
    bool is_removed_with_another = false;
    tree.visit_near(boxes[i], [&](std::uint32_t place) {
      const std::uint32_t other = tree.order()[place];
      Box3 both = boxes[other];
      both.add(boxes[i]);
      is_removed_with_another |=
          other != i && both.low == boxes[other].low && both.high == boxes[other].high;
    });
    if (is_removed_with_another) continue;
    ++filled.count;
    filled.volume -= *measures[i].volume;
  }
  return filled;
}

}  // namespace multitetra
