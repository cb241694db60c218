// The edges of a mesh, each with its uses by triangles.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

// A directed edge of a triangle, stored at its lower vertex.
struct EdgeUse {
  std::uint32_t upper;
  // The edge runs from the lower index to the upper one.
  bool upwards;

  friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};

// Calls visit(lower, uses) for every edge. `each_use` must call its argument with both ends of
// every directed edge, and the same ones in every call.
template <typename EachUse, typename Visit>
void visit_edges(std::size_t vertices, const EachUse& each_use, const Visit& visit) {
  // Sorts into buckets by the lower vertex: a counting sort, then a short sort in each bucket.
  std::vector<std::uint32_t> first(vertices + 2, 0);
  each_use([&](std::uint32_t from, std::uint32_t to) { ++first[std::min(from, to) + 2]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<EdgeUse> uses(first.back());
  each_use([&](std::uint32_t from, std::uint32_t to) {
    uses[first[std::min(from, to) + 1]++] = {std::max(from, to), from < to};
  });
  for (std::uint32_t lower = 0; lower < vertices; ++lower) {
    const auto begin = uses.begin() + first[lower];
    const auto end = uses.begin() + first[lower + 1];
    std::sort(begin, end);
    for (auto edge = begin; edge != end;) {
      const auto next =
          std::find_if(edge, end, [&](const EdgeUse& u) { return u.upper != edge->upper; });
      visit(lower, std::span<const EdgeUse>(edge, next));
      edge = next;
    }
  }
}

// Counts an edge, given all its uses. Calls `is_on_border` only for edges of a single triangle.
template <typename IsOnBorder>
void count_edge(std::span<const EdgeUse> uses, const IsOnBorder& is_on_border,
                MeshTopology& counts) {
  ++counts.edges;
  if (uses.size() == 1) {
    ++(is_on_border() ? counts.border_edges : counts.open_edges);
  } else if (uses.size() != 2 || uses[0].upwards == uses[1].upwards) {
    ++counts.nonmanifold_edges;
  }
}

}  // namespace multitetra
