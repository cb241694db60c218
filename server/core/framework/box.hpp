// Axis-aligned boxes, and their images under affine maps.
//
// Nested boxes stay nested in floating point: rounded sums, products with a fixed factor, minima
// and maxima are monotone in each operand, so rounding keeps an inner box inside.
#pragma once

#include <algorithm>

#include "common/base/affine.hpp"
#include "common/mesh/octree_cube.hpp"

namespace multitetra {

// A closed box, which includes its border; low <= high on every axis. Functions of two boxes
// require the same coordinates for both.
struct Box {
  Vec3 low;
  Vec3 high;

  friend bool operator==(const Box&, const Box&) = default;
};

// Returns the closed box of the cube, in grid steps.
[[nodiscard]] inline Box box_of(const OctreeCube& cube) {
  const auto side = static_cast<double>(cube.side());
  const Vec3 low = {side * cube.x, side * cube.y, side * cube.z};
  return {low, {low[0] + side, low[1] + side, low[2] + side}};
}

// Returns whether every point of `inner` is in `outer`.
[[nodiscard]] inline bool contains(const Box& outer, const Box& inner) {
  return outer.low[0] <= inner.low[0] && inner.high[0] <= outer.high[0] &&
         outer.low[1] <= inner.low[1] && inner.high[1] <= outer.high[1] &&
         outer.low[2] <= inner.low[2] && inner.high[2] <= outer.high[2];
}

// Returns whether the boxes have a common point, if only on their borders.
[[nodiscard]] inline bool touch(const Box& a, const Box& b) {
  return a.low[0] <= b.high[0] && b.low[0] <= a.high[0] && a.low[1] <= b.high[1] &&
         b.low[1] <= a.high[1] && a.low[2] <= b.high[2] && b.low[2] <= a.high[2];
}

// Returns `box` clamped to `bounds`: their intersection, or the nearest part of `bounds`.
[[nodiscard]] inline Box clamped(const Box& box, const Box& bounds) {
  Box inside = box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    inside.low[axis] = std::clamp(box.low[axis], bounds.low[axis], bounds.high[axis]);
    inside.high[axis] = std::clamp(box.high[axis], bounds.low[axis], bounds.high[axis]);
  }
  return inside;
}

// Returns the smallest box that contains the image of `box`.
[[nodiscard]] inline Box image_of(const Affine& map, const Box& box) {
  Box image{map.translation, map.translation};
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      const double a = map.columns[column][row] * box.low[column];
      const double b = map.columns[column][row] * box.high[column];
      image.low[row] += std::min(a, b);
      image.high[row] += std::max(a, b);
    }
  }
  return image;
}

// The least and the largest value of normal . x over a box.
struct Extent {
  double least = 0;
  double largest = 0;
};
// Returns the extent of the box along `normal`, which may have any length.
[[nodiscard]] inline Extent extent_along(const Vec3& normal, const Box& box) {
  Extent extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double a = normal[axis] * box.low[axis];
    const double b = normal[axis] * box.high[axis];
    extent.least += std::min(a, b);
    extent.largest += std::max(a, b);
  }
  return extent;
}

// Returns the squared distance from a point to the nearest point of the box, 0 inside of it.
[[nodiscard]] inline double squared_distance(const Vec3& place, const Box& box) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d =
        std::max(0.0, std::max(box.low[axis] - place[axis], place[axis] - box.high[axis]));
    sum += d * d;
  }
  return sum;
}
// Returns the squared distance from a point to the farthest point of the box.
[[nodiscard]] inline double largest_squared_distance(const Vec3& place, const Box& box) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The larger one is the distance to the farther end, wherever the place lies.
    const double d = std::max(place[axis] - box.low[axis], box.high[axis] - place[axis]);
    sum += d * d;
  }
  return sum;
}

}  // namespace multitetra
