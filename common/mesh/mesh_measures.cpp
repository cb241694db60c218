#include "common/mesh/mesh_measures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

// Returns for each component whether it has a border: an edge without an opposite one.
std::vector<bool> have_borders(const LatticeMesh& mesh, const MeshComponents& components) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  const auto edge = [](std::uint64_t from, std::uint64_t to) { return from << 32 | to; };
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.push_back(edge(t[i], t[(i + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<bool> have(components.diagonals.size(), false);
  for (const std::uint64_t one : edges) {
    const std::uint64_t from = one >> 32;
    const std::uint64_t to = one & 0xFFFFFFFF;
    if (!std::binary_search(edges.begin(), edges.end(), edge(to, from))) {
      have[components.of_vertex[from]] = true;
    }
  }
  return have;
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
  const std::vector<bool> have_border = have_borders(mesh, components);
  // A mirroring map also reverses triangles, so the inside stays the inside.
  const double scale = std::abs(grid_to_world.determinant()) * step * step * step / 6;
  for (std::size_t i = 0; i < measures.size(); ++i) {
    if (!have_border[i]) measures[i].volume = scale * static_cast<double>(six_times[i]);
  }
  return measures;
}

SurfaceMeasures sum_of(const std::vector<SurfaceMeasures>& measures) {
  SurfaceMeasures all{.area = 0, .volume = 0.0};
  for (const SurfaceMeasures& one : measures) {
    all.area += one.area;
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
