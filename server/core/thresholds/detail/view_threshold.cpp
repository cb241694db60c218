#include "server/core/thresholds/detail/view_threshold.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/exact_sine.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

// Returns the vector scaled to length 1, or 0 for 0. Divides by the largest component first, so
// that no square overflows.
Vec3 normalized(const Vec3& v) {
  const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  if (!(largest > 0)) return {0, 0, 0};
  const Vec3 near_one = {v[0] / largest, v[1] / largest, v[2] / largest};
  return scaled(near_one, 1 / std::sqrt(dot(near_one, near_one)));
}

// Returns tan(degrees / 2) with the same bits on every machine: the cosine is the sine of the
// complement to 90 degrees.
double half_tangent(double degrees) {
  return sine_of_turns(degrees / 720) / sine_of_turns((180 - degrees) / 720);
}

}  // namespace

ViewThreshold::ViewThreshold(const ThresholdView& view, const Affine& to_world, double unit)
    : to_world_(to_world), eye_(view.eye) {
  const double half_height = half_tangent(view.field_of_view);
  // Finite before the product: a tolerance of 0 pixels means threshold 0 in any view.
  const double of_a_pixel = std::min(2 * half_height / view.height_pixels, kMax);
  length_per_distance_ = std::min(view.tolerance_pixels * of_a_pixel, kMax);
  if (view.frustum) {
    outside_ = std::min(view.frustum->outside * unit, kMax);
    set_frustum(*view.frustum, half_height);
  }
}

ViewThreshold::Plane ViewThreshold::plane(const Vec3& normal) const {
  Plane plane;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    plane.normal[axis] = dot(to_world_.columns[axis], normal);
  }
  plane.offset = dot(normal, difference(eye_, to_world_.translation));
  return plane;
}

void ViewThreshold::set_frustum(const Frustum& frustum, double half_height) {
  has_frustum_ = true;
  const Vec3 forward = normalized(difference(frustum.look_at, eye_));
  const Vec3 right = normalized(cross(forward, normalized(frustum.up)));
  const Vec3 up = cross(right, forward);
  // Normals point inwards. Their lengths are arbitrary but must stay finite.
  const Vec3 vertical = scaled(forward, half_height);
  const Vec3 horizontal = scaled(forward, std::min(half_height * frustum.aspect, kMaxCoordinate));
  planes_ = {plane(sum(vertical, up)), plane(difference(vertical, up)),
             plane(sum(horizontal, right)), plane(difference(horizontal, right)), plane(forward)};
}

bool ViewThreshold::is_outside(const Box& box) const {
  return std::any_of(planes_.begin(), planes_.end(), [&box](const Plane& p) {
    return extent_along(p.normal, box).largest < p.offset;
  });
}

double ViewThreshold::at_distance(double squared) const {
  return std::min(length_per_distance_ * std::min(std::sqrt(squared), kMax), kMax);
}

double ViewThreshold::least_in(const Box& box) const {
  const double threshold = at_distance(squared_distance(eye_, image_of(to_world_, box)));
  if (!has_frustum_ || threshold >= outside_ || !is_outside(box)) return threshold;
  return outside_;
}

double ViewThreshold::largest_in(const Box& box) const {
  return std::max(outside_, at_distance(largest_squared_distance(eye_, image_of(to_world_, box))));
}

ThresholdView in_world(const ThresholdView& view, const Affine& index_to_world) {
  ThresholdView moved = view;
  moved.eye = index_to_world(view.eye);
  if (view.frustum) {
    moved.frustum->look_at = index_to_world(view.frustum->look_at);
    moved.frustum->up = difference(index_to_world(view.frustum->up), index_to_world.translation);
  }
  return moved;
}

}  // namespace multitetra
