// The threshold of a view over a box: the length that the tolerated pixels cover there.
//
// tau(x) = k |x - eye| in world units, and at least `outside` outside the frustum. It is defined
// everywhere, so there is never a gap. Monotone (threshold_interval.hpp): the world box of an inner
// box lies in that of the outer one, so it is no nearer to the eye; and when the outer box lies
// wholly on the far side of a plane of the frustum, so does the inner one.
#pragma once

#include <array>
#include <optional>

#include "common/request/local_thresholds.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

class ViewThreshold {
 public:
  // The view is in world coordinates; `to_world` maps the grid's to them, `unit` is the length of 1
  // in the thresholds' unit.
  ViewThreshold(const ThresholdView& view, const Affine& to_world, double unit);

  // World units, finite.
  [[nodiscard]] double least_in(const Box& box) const;
  // No less than least_in of any box within this one.
  [[nodiscard]] double largest_in(const Box& box) const;

 private:
  // The grid's places x with normal . x >= offset.
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
  std::array<Plane, 5> planes_;  // Planes of the frustum, if there is one: four sides and the apex.
};

// A view in sample indices as the same one in world coordinates.
[[nodiscard]] ThresholdView in_world(const ThresholdView& view, const Affine& index_to_world);

}  // namespace multitetra
