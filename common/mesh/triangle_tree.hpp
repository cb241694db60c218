// Finds the triangles of a lattice mesh near a box: a tree of bounding boxes, eight per node, whose
// triangles may change.
//
//   TriangleTree tree(boxes);                             // Numbered as they come.
//   tree.visit_near(box, [](std::uint32_t t) { ...; return false; });
//   tree.set(t, box_of(moved));
//
// Triangles keep their places in the tree, which are close together where the triangles were
// initially. Node boxes always fit their content tightly, so searches stay fast while triangles
// vanish and their neighbours grow to fill the gaps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A closed box in lattice steps.
struct TriangleBox {
  LatticePoint low;
  LatticePoint high;

  [[nodiscard]] bool touches(const TriangleBox& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y &&
           low.z <= o.high.z && o.low.z <= high.z;
  }
};
[[nodiscard]] TriangleBox box_of(const LatticeTriangle& triangle);
[[nodiscard]] TriangleBox box_around(const TriangleBox& a, const TriangleBox& b);

class TriangleTree {
 public:
  explicit TriangleTree(std::span<const TriangleBox> boxes);

  void set(std::uint32_t triangle, const TriangleBox& box);
  // Requires that the triangle is in the tree.
  void remove(std::uint32_t triangle);

  // Calls visit(triangle) for all triangles whose box touches `box` until one call returns true,
  // and returns whether one did.
  template <typename Visit>
  bool visit_near(const TriangleBox& box, const Visit& visit) const {
    if (nodes_.empty()) return false;
    // For each level, the boxes of its current node still to be visited.
    struct Waiting {
      std::uint32_t node = 0, bits = 0;
    };
    std::array<Waiting, kLevels> waiting;
    std::size_t level = first_of_level_.size() - 1;
    waiting[level] = {0, nodes_.back().touching(box)};
    while (true) {
      Waiting& here = waiting[level];
      if (here.bits == 0) {
        if (++level == first_of_level_.size()) return false;
        continue;
      }
      const auto i = static_cast<std::uint32_t>(__builtin_ctz(here.bits));
      here.bits &= here.bits - 1;
      const std::uint32_t below = here.node * kWidth + i;
      if (level > 0) {
        --level;
        waiting[level] = {below, nodes_[first_of_level_[level] + below].touching(box)};
      } else if (visit(order_[below])) {
        return true;
      }
    }
  }

 private:
  static constexpr std::uint32_t kWidth = 8;
  // 8^11 exceeds the range of 32-bit indices.
  static constexpr std::size_t kLevels = 11;
  static constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();

  using Eight = std::array<std::int32_t, kWidth>;
  // The boxes of eight triangles, or of eight nodes of the level below. Unused boxes touch nothing.
  struct Node {
    std::array<Eight, 3> low = {no_low(), no_low(), no_low()};
    std::array<Eight, 3> high = {no_high(), no_high(), no_high()};

    [[nodiscard]] TriangleBox box(std::uint32_t i) const {
      return {{low[0][i], low[1][i], low[2][i]}, {high[0][i], high[1][i], high[2][i]}};
    }
    void set(std::uint32_t i, const TriangleBox& box);
    // Returns the box around all of them.
    [[nodiscard]] TriangleBox box() const;
    // Returns one bit for each box that touches `box`.
    [[nodiscard]] std::uint32_t touching(const TriangleBox& box) const {
      Eight apart;  // Written so that compilers vectorize the comparisons.
      for (std::uint32_t i = 0; i < kWidth; ++i) {
        apart[i] = static_cast<std::int32_t>(low[0][i] > box.high.x) |
                   static_cast<std::int32_t>(high[0][i] < box.low.x) |
                   static_cast<std::int32_t>(low[1][i] > box.high.y) |
                   static_cast<std::int32_t>(high[1][i] < box.low.y) |
                   static_cast<std::int32_t>(low[2][i] > box.high.z) |
                   static_cast<std::int32_t>(high[2][i] < box.low.z);
      }
      std::uint32_t bits = 0;
      for (std::uint32_t i = 0; i < kWidth; ++i) {
        bits |= static_cast<std::uint32_t>(1 - apart[i]) << i;
      }
      return bits;
    }
  };
  static constexpr Eight no_low() { return filled(kHighest); }
  static constexpr Eight no_high() { return filled(kLowest); }
  static constexpr Eight filled(std::int32_t value) {
    Eight eight{};
    eight.fill(value);
    return eight;
  }

  void add_level();

  // A place is the index of a triangle in leaf order.
  std::vector<std::uint32_t> order_;   // The triangle at each place.
  std::vector<std::uint32_t> places_;  // The place of each triangle.
  std::vector<Node> nodes_;            // Leaves first, the root last.
  std::vector<std::size_t> first_of_level_;
};

}  // namespace multitetra
