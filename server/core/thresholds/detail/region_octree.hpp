// The least threshold of many regions over a box, in less than linear time.
//
// An octree over the grid. A leaf holds the short list of regions that may apply in its cube; every
// node stores the least threshold below it and whether it may have places that no region contains.
// A query is the minimum over the leaves that the box touches: a cube inside the box contributes
// its node's bound at once, a cube that cannot lower the result is skipped, and a leaf at the
// border of the box tests its regions against its part of the box. Where the borders of very many
// regions cross in a small cube, the least threshold of them is used for the whole cube.
//
// The result is monotone (threshold_bound.hpp): an inner box touches no leaf that the outer one
// does not touch, its part of a leaf lies in the outer box's part, and the result for a part is the
// minimum over the regions that touch it and are not hidden by a later region that contains it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "server/core/framework/box.hpp"
#include "server/core/thresholds/detail/region_set.hpp"
#include "server/core/thresholds/detail/threshold_bound.hpp"

namespace multitetra {

class RegionOctree {
 public:
  // Accepts queries for boxes within `places`, which must lie in the cube from the origin with
  // 2^exponent steps a side. Time and memory are bounded by about 2^20 list entries for any
  // regions: a second at worst. `check`, if set, is called repeatedly meanwhile and may throw.
  RegionOctree(RegionSet regions, const Box& places, int exponent,
               const std::function<void()>& check = {});

  // Requires a box within the places. Costs a few comparisons for each cube at the box's border.
  [[nodiscard]] ThresholdBound least_in(const Box& box) const;

 private:
  struct Node {
    double least = 0;
    bool has_gap = false;
    bool has_children = false;
    bool is_constant = false;  // The bound applies to the whole cube.
    // Index of the first of its eight children, or of its list.
    std::uint32_t first = 0;
    // Length of its list.
    std::uint32_t count = 0;
  };
  // A node with its cube's low corner and side.
  struct Cube {
    std::uint32_t node = 0;
    Vec3 low = {};
    double side = 0;
  };
  // A cube with its list of regions.
  struct Leaf {
    Cube cube;
    RegionSet::List list;
  };

  [[nodiscard]] Box box_of(const Cube& cube) const;  // Clipped to the places.
  [[nodiscard]] static Cube child(const Cube& cube, std::uint32_t first, unsigned octant);
  void build(RegionSet::List all, const std::function<void()>& check);
  void set_bound(const Leaf& leaf);
  [[nodiscard]] bool is_divisible(const Leaf& leaf, std::size_t entries) const;
  [[nodiscard]] std::vector<Leaf> divide(const Leaf& leaf);
  void store(const Leaf& leaf);
  void propagate_bounds();
  void add(const Cube& cube, const Box& box, ThresholdBound& bound) const;
  void add_leaf(const Node& node, const Box& part, ThresholdBound& bound) const;

  RegionSet regions_;
  Box places_;
  double side_;
  std::vector<Node> nodes_;
  std::vector<RegionSet::Index> lists_;
};

}  // namespace multitetra
