#include "common/mesh/components.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/mesh/disjoint_sets.hpp"

namespace multitetra {
namespace {

// A box in lattice steps.
struct LatticeBox {
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;

  LatticeBox() {
    low.fill(std::numeric_limits<std::int32_t>::max());
    high.fill(std::numeric_limits<std::int32_t>::min());
  }
  void add(const LatticePoint& p) {
    const std::array<std::int32_t, 3> place = {p.x, p.y, p.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], place[axis]);
      high[axis] = std::max(high[axis], place[axis]);
    }
  }
  // The sum is exact up to 2^25 lattice steps per side, so the only rounding is that of the root:
  // the result is the same everywhere, which std::hypot does not guarantee.
  [[nodiscard]] double diagonal() const {
    double squares = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double side = double{1} * high[axis] - low[axis];
      squares += side * side;
    }
    return std::sqrt(squares);
  }
};

// Returns the components for which `is_kept(component)`, in order, with normals and scalars.
template <typename IsKept>
LatticeMesh chosen(const LatticeMesh& mesh, const MeshComponents& components,
                   const IsKept& is_kept_component) {
  LatticeMesh kept{.resolution = mesh.resolution, .vertices = {}, .triangles = {}};
  std::vector<std::uint32_t> number(mesh.vertices.size());
  const auto is_kept = [&](std::uint32_t v) { return is_kept_component(components.of_vertex[v]); };
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!is_kept(v)) continue;
    number[v] = static_cast<std::uint32_t>(kept.vertices.size());
    kept.vertices.push_back(mesh.vertices[v]);
    if (!mesh.normals.empty()) kept.normals.push_back(mesh.normals[v]);
    if (!mesh.scalars.empty()) kept.scalars.push_back(mesh.scalars[v]);
  }
  for (const TriangleIndices& t : mesh.triangles) {
    if (is_kept(t[0])) kept.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return kept;
}

}  // namespace

std::uint32_t MeshComponents::largest() const {
  const auto longest = std::max_element(diagonals.begin(), diagonals.end());
  return static_cast<std::uint32_t>(longest - diagonals.begin());
}

double MeshComponents::least(double min_diagonal) const {
  return min_diagonal == kLargestAlone && !diagonals.empty() ? diagonals[largest()] : min_diagonal;
}

std::size_t MeshComponents::count_at_least(double min_diagonal) const {
  const double shortest = least(min_diagonal);
  return static_cast<std::size_t>(std::count_if(
      diagonals.begin(), diagonals.end(), [&](double diagonal) { return diagonal >= shortest; }));
}

MeshComponents components_of(const LatticeMesh& mesh) {
  DisjointSets sets(mesh.vertices.size());
  for (const TriangleIndices& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  MeshComponents components;
  components.of_vertex.resize(mesh.vertices.size());
  std::vector<LatticeBox> boxes;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::uint32_t root = sets.root(v);  // The least vertex of its set, so it comes first.
    if (root == v) {
      components.of_vertex[v] = static_cast<std::uint32_t>(boxes.size());
      boxes.emplace_back();
    } else {
      components.of_vertex[v] = components.of_vertex[root];
    }
    boxes[components.of_vertex[v]].add(mesh.vertices[v]);
  }
  const double step = std::ldexp(1.0, -mesh.resolution);
  for (const LatticeBox& box : boxes) components.diagonals.push_back(box.diagonal() * step);
  return components;
}

LatticeMesh with_components(const LatticeMesh& mesh, const MeshComponents& components,
                            double min_diagonal) {
  const double shortest = components.least(min_diagonal);
  return chosen(mesh, components,
                [&](std::uint32_t one) { return components.diagonals[one] >= shortest; });
}

LatticeMesh without_components(const LatticeMesh& mesh, const MeshComponents& components,
                               double min_diagonal) {
  const double shortest = components.least(min_diagonal);
  return chosen(mesh, components,
                [&](std::uint32_t one) { return components.diagonals[one] < shortest; });
}

}  // namespace multitetra
