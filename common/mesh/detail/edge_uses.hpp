// The edges of a mesh and their uses by triangles.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

enum class EdgeUses : std::uint32_t {
  kOther = 0,      // By more than two triangles, or by two in the same direction.
  kUpwards = 1,    // By one, from the lower index to the upper one.
  kDownwards = 2,  // By one, from the upper index to the lower one.
  kTwo = 3,        // By two in opposite directions.
};

// Calls visit(lower, upper, uses) for every edge. `each_use` must call its argument with both ends
// of every directed edge, and the same ones in every call. Requires fewer than 2^30 vertices.
template <typename EachUse, typename Visit>
void visit_edges(std::size_t vertices, const EachUse& each_use, const Visit& visit) {
  assert(vertices < std::size_t{1} << 30);
  // Buckets by the lower vertex, with room for one entry per use.
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  each_use([&](std::uint32_t from, std::uint32_t to) { ++begin[std::min(from, to) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> edges(begin.back(), 0);  // 4 upper + uses; 0: free.
  each_use([&](std::uint32_t from, std::uint32_t to) {
    const std::uint32_t upper = std::max(from, to);
    const std::uint32_t use = from < to ? 1 : 2;
    std::uint32_t* edge = &edges[begin[std::min(from, to)]];
    while (*edge != 0 && *edge / 4 != upper) ++edge;
    const std::uint32_t before = *edge % 4;
    const bool is_regular = *edge == 0 || before + use == 3;
    *edge = 4 * upper + (is_regular ? before + use : 0);
  });
  for (std::uint32_t lower = 0; lower < vertices; ++lower) {
    for (std::uint32_t i = begin[lower]; i < begin[lower + 1] && edges[i] != 0; ++i) {
      visit(lower, edges[i] / 4, static_cast<EdgeUses>(edges[i] % 4));
    }
  }
}

// Counts an edge. Calls `is_on_border` only for edges of a single triangle.
template <typename IsOnBorder>
void count_edge(EdgeUses uses, const IsOnBorder& is_on_border, MeshTopology& counts) {
  ++counts.edges;
  if (uses == EdgeUses::kOther) {
    ++counts.nonmanifold_edges;
  } else if (uses != EdgeUses::kTwo) {
    ++(is_on_border() ? counts.border_edges : counts.open_edges);
  }
}

}  // namespace multitetra
