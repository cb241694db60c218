// Disjoint sets (union-find), for connected components.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace multitetra {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t things) : parent_(things) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }
  void join(std::uint32_t a, std::uint32_t b) {
    if (parent_[a] == parent_[b]) return;  // The common case for neighbours in a mesh.
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  // Returns the least element of the set that contains `v`.
  [[nodiscard]] std::uint32_t root(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  [[nodiscard]] std::int64_t count() const {
    std::int64_t roots = 0;
    for (std::uint32_t v = 0; v < parent_.size(); ++v) roots += parent_[v] == v;
    return roots;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace multitetra
