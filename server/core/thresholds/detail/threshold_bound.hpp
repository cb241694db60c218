// The bound of one part of a threshold map over a box.
//
// The parts (regions, grid, view) implement least_in(box) with one guarantee: for a box inside
// another, `least` is not smaller and `has_gap` is set only if it is set for the outer box, bit for
// bit. Each consists of steps that are monotone as computed (box.hpp), of minima over sets that
// only shrink with the box, and of decisions that also hold for every inner box. A place is a box
// without extent, so the bound of a box is never above that of a place in it.
#pragma once

#include <limits>

namespace multitetra {

struct ThresholdBound {
  // World units; infinite without a threshold.
  double least = std::numeric_limits<double>::infinity();
  // Set if the box may have places without a threshold.
  bool has_gap = false;

  friend bool operator==(const ThresholdBound&, const ThresholdBound&) = default;
};

}  // namespace multitetra
