// The bound of one part of a threshold map over a box of places.
//
// The parts (regions, grid, view) implement least_in(box) with one guarantee: for a box inside
// another, `least` is never smaller and `has_gap` is never set where the other's is not, bit for
// bit. Each is made of steps that are monotone as computed (box.hpp), of minima over sets that only
// shrink with the box, and of decisions that hold for every box inside one they hold for. A place
// is a box without extent, so the bound of a box is never above that of a place in it.
#pragma once

#include <limits>

namespace multitetra {

struct ThresholdInterval {
  double least = std::numeric_limits<double>::infinity();  // World units; infinite: no threshold.
  // There may be places without a threshold.
  bool has_gap = false;

  friend bool operator==(const ThresholdInterval&, const ThresholdInterval&) = default;
};

}  // namespace multitetra
