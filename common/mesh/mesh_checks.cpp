#include "common/mesh/mesh_checks.hpp"

#include <algorithm>
#include <vector>

#include "common/mesh/detail/edge_uses.hpp"
#include "common/mesh/disjoint_sets.hpp"

namespace multitetra {
namespace {

bool is_degenerate(const TriangleIndices& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

}  // namespace

bool DataBorder::contains_edge(const LatticePoint& a, const LatticePoint& b) const {
  if (anywhere) return true;
  const auto both_near = [this](std::int32_t a1, std::int32_t b1, std::int32_t low1,
                                std::int32_t high1) {
    return std::max(a1, b1) <= low1 + inset || std::min(a1, b1) >= high1 - inset;
  };
  return both_near(a.x, b.x, low.x, high.x) || both_near(a.y, b.y, low.y, high.y) ||
         both_near(a.z, b.z, low.z, high.z);
}

MeshTopology topology(const LatticeMesh& mesh, const DataBorder& border) {
  return topology(mesh.vertices.size(), mesh.triangles, [&](std::uint32_t a, std::uint32_t b) {
    return border.contains_edge(mesh.vertices[a], mesh.vertices[b]);
  });
}

MeshTopology topology(std::size_t vertices, std::span<const TriangleIndices> triangles,
                      const std::function<bool(std::uint32_t, std::uint32_t)>& is_on_border) {
  MeshTopology result;
  result.vertices = static_cast<std::int64_t>(vertices);
  result.triangles = static_cast<std::int64_t>(triangles.size());

  DisjointSets components(vertices);
  for (const TriangleIndices& t : triangles) {
    components.join(t[0], t[1]);
    components.join(t[1], t[2]);
    if (is_degenerate(t)) ++result.degenerate_triangles;
  }
  const auto each_use = [triangles](const auto& use) {
    for (const TriangleIndices& t : triangles) {
      if (is_degenerate(t)) continue;
      for (std::size_t i = 0; i < 3; ++i) use(t[i], t[(i + 1) % 3]);
    }
  };
  visit_edges(vertices, each_use, [&](std::uint32_t lower, std::uint32_t upper, EdgeUses uses) {
    count_edge(
        uses, [&] { return is_on_border(lower, upper); }, result);
  });
  result.euler_characteristic = result.vertices - result.edges + result.triangles;
  result.components = components.count();
  return result;
}

std::int64_t nonmanifold_vertices(std::size_t vertices,
                                  std::span<const TriangleIndices> triangles) {
  // Unites a vertex's corners whose triangles share an edge there. Corner 3 t + i is of triangle t.
  struct Side {
    std::uint32_t upper;
    std::uint32_t lower_corner;
    std::uint32_t upper_corner;
  };
  std::vector<std::uint32_t> first(vertices + 2, 0);
  for (const TriangleIndices& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++first[std::min(t[i], t[(i + 1) % 3]) + 2];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Side> sides(first.back());
  for (std::uint32_t number = 0; number < triangles.size(); ++number) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t j = (i + 1) % 3;
      const std::uint32_t a = triangles[number][i];
      const std::uint32_t b = triangles[number][j];
      sides[first[std::min(a, b) + 1]++] = {.upper = std::max(a, b),
                                            .lower_corner = 3 * number + (a < b ? i : j),
                                            .upper_corner = 3 * number + (a < b ? j : i)};
    }
  }
  DisjointSets fans(3 * triangles.size());
  for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
    const auto begin = sides.begin() + first[vertex];
    const auto end = sides.begin() + first[vertex + 1];
    std::sort(begin, end, [](const Side& a, const Side& b) { return a.upper < b.upper; });
    for (auto side = begin; side != end; ++side) {
      if (side == begin || side->upper != (side - 1)->upper) continue;
      fans.join(side->lower_corner, (side - 1)->lower_corner);
      fans.join(side->upper_corner, (side - 1)->upper_corner);
    }
  }
  // Counts the fans of each vertex once, at their first corners.
  std::vector<std::uint8_t> fans_of(vertices, 0);
  std::int64_t result = 0;
  for (std::uint32_t corner = 0; corner < 3 * triangles.size(); ++corner) {
    if (fans.root(corner) != corner) continue;
    std::uint8_t& count = fans_of[triangles[corner / 3][corner % 3]];
    if (count == 1) ++result;
    if (count < 2) ++count;
  }
  return result;
}

}  // namespace multitetra
