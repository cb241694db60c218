// What one part of a threshold map says over a box of places.
//
// The parts (regions, grid, view) answer least_in(box), and all of them keep one promise: for a box
// inside another, `least` is never smaller and `has_gap` is never set where the other's is not, bit
// for bit. Each is made of steps that are monotone as computed (box.hpp), of minima over sets that
// only shrink with the box, and of decisions that hold for every box inside one they hold for.
// A place is a box without extent, so the answer for a box is never above that for a place in it.
#pragma once

#include <limits>

namespace multitetra {

struct ThresholdBound {
  double least =
      std::numeric_limits<double>::infinity();  // World units; infinite: nothing is said.
  bool has_gap = false;                         // There may be places about which nothing is said.

  friend bool operator==(const ThresholdBound&, const ThresholdBound&) = default;
};

}  // namespace multitetra
