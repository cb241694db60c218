// The edges of a mesh and their uses by triangles.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
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
  constexpr std::size_t kFewUses = 64;  // Those of the hub of a fan are compared after sorting.
  assert(vertices < std::size_t{1} << 30);
  // Buckets by the lower vertex: a counting sort.
  std::vector<std::uint32_t> begin(vertices + 2, 0);
  each_use([&](std::uint32_t from, std::uint32_t to) { ++begin[std::min(from, to) + 2]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> all(begin.back());  // 4 upper + use.
  each_use([&](std::uint32_t from, std::uint32_t to) {
    all[begin[std::min(from, to) + 1]++] = 4 * std::max(from, to) + (from < to ? 1 : 2);
  });
  for (std::uint32_t lower = 0; lower < vertices; ++lower) {
    const auto uses = std::span(all).subspan(begin[lower], begin[lower + 1] - begin[lower]);
    const bool is_sorted = uses.size() > kFewUses;
    if (is_sorted) std::sort(uses.begin(), uses.end());
    for (std::size_t i = 0; i < uses.size(); ++i) {
      if (uses[i] == 0) continue;  // Counted with an earlier one.
      const std::uint32_t upper = uses[i] / 4;
      std::uint32_t sum = uses[i] % 4;
      for (std::size_t k = i + 1; k < uses.size(); ++k) {
        if (uses[k] / 4 == upper && uses[k] != 0) {
          sum = sum != 0 && sum + uses[k] % 4 == 3 ? 3 : 0;
          uses[k] = 0;
        } else if (is_sorted) {
          break;
        }
      }
      visit(lower, upper, static_cast<EdgeUses>(sum));
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
