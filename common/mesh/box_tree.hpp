// A bounding volume hierarchy: finds boxes by location without testing all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <stop_token>
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
  [[nodiscard]] bool touches(const Box3& other) const {  // Boxes are closed.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (low[axis] > other.high[axis] || high[axis] < other.low[axis]) return false;
    }
    return true;
  }
  [[nodiscard]] double squared_distance(const Vec3& point) const {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double below = low[axis] - point[axis];
      const double above = point[axis] - high[axis];
      const double outside = std::max(std::max(below, above), 0.0);
      sum += outside * outside;
    }
    return sum;
  }
};

// Immutable and therefore thread-safe. Takes about 30 bytes per box.
class BoxTree {
 public:
  // Throws Cancelled soon after `stop` is triggered.
  explicit BoxTree(std::span<const Box3> boxes, const std::stop_token& stop = {});

  // Returns the indices of the boxes in leaf order. Searches identify boxes by their place in this
  // order: data stored in the same order is close in memory where it is close in space.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

  // Calls `visit(place)` for all boxes in leaves that meet `box`, a superset of the boxes that do.
  template <typename Visit>
  void visit_near(const Box3& box, const Visit& visit) const {
    if (nodes_.empty()) return;
    Stack<std::uint32_t> waiting;
    waiting.push(0);
    while (!waiting.is_empty()) {
      const std::uint32_t index = waiting.pop();
      const Node& node = nodes_[index];
      if (!node.box.touches(box)) continue;
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
  // Returns the place with the least `squared_distance(place)`, which must be at least the squared
  // distance of the point from the box. Searches only for distances less than `below`, which is
  // returned if there are none.
  template <typename SquaredDistance>
  [[nodiscard]] Nearest nearest(const Vec3& point, const SquaredDistance& squared_distance,
                                double below = std::numeric_limits<double>::infinity()) const {
    Nearest best = {.squared_distance = below};
    if (nodes_.empty()) return best;
    struct Waiting {
      std::uint32_t node;
      double distance;  // Squared, to the node's box.
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
  // The first child of an inner node is the next node.
  struct Node {
    Box3 box;
    // The place of a leaf's first box, or the index of an inner node's second child.
    std::uint32_t first = 0;
    // The number of boxes in a leaf; 0 for an inner node.
    std::uint32_t count = 0;
  };
  struct Entry {
    Vec3 center;
    std::uint32_t number;
  };
  // Holds at most one entry per level, of which there are fewer than 33.
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

  void build(std::span<const Box3> boxes, std::span<Entry> entries, std::uint32_t first,
             const std::stop_token& stop);

  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace multitetra
