#include "client/picture/camera.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numbers>

#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

constexpr double kFieldOfView = 35;  // Degrees, of the shorter side.
// The filled part of the picture's half width and height.
constexpr double kFilled = 0.92;

struct Bounds {
  Vec3 low;
  Vec3 high;
};

Bounds bounds_of(std::span<const std::array<float, 3>> places) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds bounds = {.low = {kFar, kFar, kFar}, .high = {-kFar, -kFar, -kFar}};
  for (const auto& place : places) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min<double>(bounds.low[axis], place[axis]);
      bounds.high[axis] = std::max<double>(bounds.high[axis], place[axis]);
    }
  }
  if (places.empty()) bounds = {.low = {-1, -1, -1}, .high = {1, 1, 1}};
  return bounds;
}

}  // namespace

Vec3 Camera::seen(const Vec3& place) const {
  const Vec3 from_eye = difference(place, eye);
  return {dot(from_eye, right), dot(from_eye, up), dot(from_eye, back)};
}

Camera framing(std::span<const std::array<float, 3>> places, double azimuth, double elevation,
               int width, int height) {
  assert(width > 0 && height > 0);
  constexpr double kRadian = std::numbers::pi / 180;
  const double turn = azimuth * kRadian;
  const double rise = elevation * kRadian;
  const double slope = std::tan(kFieldOfView / 2 * kRadian);
  Camera camera{
      .width = width,
      .height = height,
      .right = {std::cos(turn), std::sin(turn), 0},
      .up = {-std::sin(rise) * std::sin(turn), std::sin(rise) * std::cos(turn), std::cos(rise)},
      .back = {std::cos(rise) * std::sin(turn), -std::cos(rise) * std::cos(turn), std::sin(rise)},
      .pixels_at_one = std::min(width, height) / (2 * slope)};
  const Bounds bounds = bounds_of(places);
  Vec3 middle;
  double radius = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    middle[axis] = (bounds.low[axis] + bounds.high[axis]) / 2;
    radius = std::max(radius, (bounds.high[axis] - bounds.low[axis]) / 2);
  }
  if (radius == 0) radius = 1;
  // A place that is `ahead` of the middle, towards the eye, is inside the picture when the eye is
  // at least so far from the middle.
  const double across = kFilled * width / (2 * camera.pixels_at_one);
  const double upwards = kFilled * height / (2 * camera.pixels_at_one);
  double distance = places.empty() ? 4 * radius : 0;
  for (const auto& place : places) {
    const Vec3 from_middle = difference(vec3(place), middle);
    const double needed = std::max(std::abs(dot(from_middle, camera.right)) / across,
                                   std::abs(dot(from_middle, camera.up)) / upwards);
    distance = std::max(distance, dot(from_middle, camera.back) + std::max(needed, 0.1 * radius));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    camera.eye[axis] = middle[axis] + distance * camera.back[axis];
  }
  return camera;
}

}  // namespace multitetra
