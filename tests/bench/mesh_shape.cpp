#include "tests/bench/mesh_shape.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

// Returns whether both places lie on one side of the data's box, or up to `depth` inside it.
bool on_border(const std::array<float, 3>& p, const std::array<float, 3>& q, const Vec3& high,
               double depth) {
  constexpr double kRounding = 1e-3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double a = p[axis];
    const double b = q[axis];
    if (std::max(a, b) <= depth + kRounding) return true;
    if (std::min(a, b) >= high[axis] - depth - kRounding) return true;
  }
  return false;
}

}  // namespace

Shape shape_of(const PlainMesh& mesh, const Vec3& high, double border) {
  std::vector<std::uint32_t> group(mesh.positions.size());
  std::iota(group.begin(), group.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (group[v] != v) v = group[v] = group[group[v]];
    return v;
  };
  std::vector<bool> is_used(mesh.positions.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      is_used[a] = true;
      group[root(a)] = root(b);
      edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  Shape shape;
  std::int64_t distinct = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j] == edges[i]) ++j;
    ++distinct;
    const auto& [a, b] = edges[i];
    if (j - i == 1 && !on_border(mesh.positions[a], mesh.positions[b], high, border)) {
      ++shape.open_edges;
    }
    if (j - i > 2) ++shape.nonmanifold_edges;
    i = j;
  }
  std::int64_t vertices = 0;
  for (std::uint32_t v = 0; v < is_used.size(); ++v) {
    if (!is_used[v]) continue;
    ++vertices;
    if (root(v) == v) ++shape.components;
  }
  shape.euler_characteristic =
      vertices - distinct + static_cast<std::int64_t>(mesh.triangles.size());
  return shape;
}

}  // namespace multitetra
