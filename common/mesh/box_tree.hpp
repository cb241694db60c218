// A bounding volume hierarchy: boxes in space, found by place without looking at all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/base/vec3.hpp"

namespace multitetra {

struct Box3 {
  Vec3 low = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
              std::numeric_limits<double>::infinity()};
  Vec3 high = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
               -std::numeric_limits<double>::infinity()};

  void add(const Vec3& point);
  void add(const Box3& box);
  [[nodiscard]] bool meets(const Box3& other) const {  // Closed boxes.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (low[axis] > other.high[axis] || high[axis] < other.low[axis]) return false;
    }
    return true;
  }
  [[nodiscard]] double squared_distance(const Vec3& point) const;
};

// Immutable, so that any thread may search it. About 30 bytes a box.
class BoxTree {
 public:
  explicit BoxTree(std::span<const Box3> boxes);

  // The numbers of all boxes in the order of the leaves. Searches name boxes by their places in
  // this order, so that what is kept in the same order is near in memory where it is near in space.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

  // Calls `visit(place)` for all boxes that may meet `box`: those of the leaves that do.
  template <typename Visit>
  void visit_near(const Box3& box, const Visit& visit) const {
    if (nodes_.empty()) return;
    Stack<std::uint32_t> waiting;
    waiting.push(0);
    while (!waiting.is_empty()) {
      const std::uint32_t index = waiting.pop();
      const Node& node = nodes_[index];
      if (!node.box.meets(box)) continue;
      if (node.count == 0) {
        waiting.push(node.first);
        waiting.push(index + 1);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(i);
    }
  }

  struct Nearest {
    double squared_distance = std::numeric_limits<double>::infinity();
    std::uint32_t place = std::numeric_limits<std::uint32_t>::max();
  };
  // The box with the least `squared_distance(place)`, a number that must not be less than that of
  // the point from the box; without boxes it is infinitely far.
  template <typename SquaredDistance>
  [[nodiscard]] Nearest nearest(const Vec3& point, const SquaredDistance& squared_distance) const {
    Nearest best;
    if (nodes_.empty()) return best;
    struct Waiting {
      std::uint32_t node;
      double distance;  // Squared, to its box.
    };
    Stack<Waiting> waiting;
    waiting.push({0, nodes_[0].box.squared_distance(point)});
    while (!waiting.is_empty()) {
      const Waiting next = waiting.pop();
      if (next.distance >= best.squared_distance) continue;
      const Node& node = nodes_[next.node];
      if (node.count > 0) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
          const double distance = squared_distance(i);
          if (distance < best.squared_distance) best = {distance, i};
        }
        continue;
      }
      Waiting near = {next.node + 1, nodes_[next.node + 1].box.squared_distance(point)};
      Waiting far = {node.first, nodes_[node.first].box.squared_distance(point)};
      if (far.distance < near.distance) std::swap(near, far);
      waiting.push(far);
      waiting.push(near);
    }
    return best;
  }

 private:
  // Inner nodes are split in two, the first of which follows at once.
  struct Node {
    Box3 box;
    // The first box of a leaf; the second child of an inner node.
    std::uint32_t first = 0;
    // The number of boxes of a leaf; 0 for an inner node.
    std::uint32_t count = 0;
  };
  struct Entry {
    Vec3 centre;
    std::uint32_t number;
  };
  // One entry for each level at most: there are fewer than 33.
  template <typename T>
  class Stack {
   public:
    void push(const T& value) { values_[count_++] = value; }
    T pop() { return values_[--count_]; }
    [[nodiscard]] bool is_empty() const { return count_ == 0; }

   private:
    std::array<T, 64> values_;
    std::size_t count_ = 0;
  };

  void build(std::span<const Box3> boxes, std::span<Entry> entries, std::uint32_t first);

  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace multitetra
