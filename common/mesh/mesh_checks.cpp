#include "common/mesh/mesh_checks.hpp"

#include <algorithm>
#include <vector>

#include "common/mesh/detail/disjoint_sets.hpp"

namespace multitetra {
namespace {

// The other end of a directed edge, packed so that the edges from one lower vertex sort by their
// upper vertex.
struct EdgeUse {
  std::uint32_t upper;
  bool upwards;  // The triangle runs from the lower index to the upper one.

  friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};

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
  MeshTopology result;
  result.vertices = static_cast<std::int64_t>(mesh.vertices.size());
  result.triangles = static_cast<std::int64_t>(mesh.triangles.size());

  // Edges sorted into buckets by their lower vertex: a counting sort, then a short sort in each
  // bucket.
  std::vector<std::uint32_t> first(mesh.vertices.size() + 2, 0);
  DisjointSets components(mesh.vertices.size());
  for (const TriangleIndices& t : mesh.triangles) {
    components.join(t[0], t[1]);
    components.join(t[1], t[2]);
    if (is_degenerate(t)) {
      ++result.degenerate_triangles;
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) ++first[std::min(t[i], t[(i + 1) % 3]) + 2];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<EdgeUse> uses(first.back());
  for (const TriangleIndices& t : mesh.triangles) {
    if (is_degenerate(t)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i];
      const std::uint32_t to = t[(i + 1) % 3];
      uses[first[std::min(from, to) + 1]++] = {std::max(from, to), from < to};
    }
  }

  for (std::uint32_t lower = 0; lower < mesh.vertices.size(); ++lower) {
    const auto begin = uses.begin() + first[lower];
    const auto end = uses.begin() + first[lower + 1];
    std::sort(begin, end);
    for (auto edge = begin; edge != end;) {
      const auto next =
          std::find_if(edge, end, [&](const EdgeUse& u) { return u.upper != edge->upper; });
      ++result.edges;
      if (next - edge == 1) {
        const bool on_border =
            border.contains_edge(mesh.vertices[lower], mesh.vertices[edge->upper]);
        ++(on_border ? result.border_edges : result.open_edges);
      } else if (next - edge != 2 || edge->upwards == (edge + 1)->upwards) {
        ++result.nonmanifold_edges;
      }
      edge = next;
    }
  }
  result.euler_characteristic = result.vertices - result.edges + result.triangles;
  result.components = components.count();
  return result;
}

}  // namespace multitetra
