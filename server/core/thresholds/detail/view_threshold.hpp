// The threshold of a view over a box: the length that the tolerated pixels cover there.
//
// tau(x) = k |x - eye| in world units, and at least `outside` outside the frustum. It is defined
// everywhere, so there is never a gap. Monotone (threshold_bound.hpp): the world box of an inner
// box lies in that of the outer one, so it is no nearer to the eye; and if the outer box lies
// wholly beyond a plane of the frustum, so does the inner one.
#pragma once

#include <array>
#include <optional>

#include "common/request/local_thresholds.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

class ViewThreshold {
 public:
  // The view is in world coordinates; `to_world` maps grid coordinates to them; `unit` is the world
  // length of the thresholds' unit.
  ViewThreshold(const ThresholdView& view, const Affine& to_world, double unit);

  // Returns a finite threshold in world units.
  [[nodiscard]] double least_in(const Box& box) const;
  // Returns an upper bound of least_in for any box within this one.
  [[nodiscard]] double largest_in(const Box& box) const;

 private:
  // The half-space normal . x >= offset in grid coordinates.
  struct Plane {
    Vec3 normal = {};
    double offset = 0;
  };
  [[nodiscard]] Plane plane(const Vec3& normal) const;
  void set_frustum(const Frustum& frustum, double half_height);
  [[nodiscard]] bool is_outside(const Box& box) const;
  [[nodiscard]] double at_distance(double squared) const;

  Affine to_world_;
  Vec3 eye_;
  double length_per_distance_;  // k
  double outside_ = 0;
  bool has_frustum_ = false;
  std::array<Plane, 5> planes_;  // With a frustum: its four sides and the plane through its apex.
};

// Converts a view from sample indices to world coordinates.
[[nodiscard]] ThresholdView in_world(const ThresholdView& view, const Affine& index_to_world);

}  // namespace multitetra
