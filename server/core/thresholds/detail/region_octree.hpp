// The least threshold of many regions over a box, without visiting all of them.
//
// An octree over the grid. A leaf keeps the short list of regions that may hold in its cube; every
// node stores the least threshold below it and whether there may be places that no region contains.
// A query is the minimum over the leaves that the box touches: a cube inside the box contributes
// its node's bound at once, one that cannot lower the result is skipped, and a leaf at the box's
// border compares its regions with the part of the box inside it. Where the borders of very many
// regions cross in one small cube, the least of them stands for the whole cube.
//
// The result is monotone (threshold_interval.hpp): an inner box touches no leaf that the outer one
// does not touch, its part there lies in the outer one's part, and for a part it is the minimum
// over the regions that touch it and are not hidden by a later one that contains it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "server/core/framework/box.hpp"
#include "server/core/thresholds/detail/region_set.hpp"
#include "server/core/thresholds/detail/threshold_interval.hpp"

namespace multitetra {

class RegionOctree {
 public:
  // For boxes within `places`, which lie in the cube from the origin with 2^exponent steps a side.
  // Costs memory and time of at most about 2^20 entries of lists, however the regions lie, which
  // is a second at worst: `check`, if there is one, is called again and again meanwhile and may
  // throw.
  RegionOctree(RegionSet regions, const Box& places, int exponent,
               const std::function<void()>& check = {});

  // Requires a box within the places. Costs some comparisons for each cube at the box's border.
  [[nodiscard]] ThresholdInterval least_in(const Box& box) const;

 private:
  struct Node {
    double least = 0;
    bool has_gap = false;
    bool has_children = false;
    bool is_constant = false;  // One bound holds for all of it.
    // The first of its eight children, or of its list.
    std::uint32_t first = 0;
    // The length of its list.
    std::uint32_t count = 0;
  };
  // A node with the low corner and the side of its cube.
  struct Cube {
    std::uint32_t node = 0;
    Vec3 low = {};
    double side = 0;
  };
  // A cube with its list.
  struct Leaf {
    Cube cube;
    RegionSet::List list;
  };

  [[nodiscard]] Box box_of(const Cube& cube) const;  // Within the places.
  [[nodiscard]] static Cube child(const Cube& cube, std::uint32_t first, unsigned octant);
  void grow(RegionSet::List all, const std::function<void()>& check);
  void settle(const Leaf& leaf);
  [[nodiscard]] bool is_divisible(const Leaf& leaf, std::size_t entries) const;
  [[nodiscard]] std::vector<Leaf> divide(const Leaf& leaf);
  void store(const Leaf& leaf);
  void sum_up();
  void add(const Cube& cube, const Box& box, ThresholdInterval& bound) const;
  void add_leaf(const Node& node, const Box& part, ThresholdInterval& bound) const;

  RegionSet regions_;
  Box places_;
  double side_;
  std::vector<Node> nodes_;
  std::vector<RegionSet::Index> lists_;
};

}  // namespace multitetra
