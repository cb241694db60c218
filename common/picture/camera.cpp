#include "common/picture/camera.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numbers>

#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

constexpr double kFieldOfView = 35;  // Degrees, of the shorter side.
// The part of the picture's half width and height that is filled.
constexpr double kFilled = 0.92;

struct Bounds {
  Vec3 low;
  Vec3 high;
};

Bounds bounds_of(std::span<const Vec3> points) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds bounds = {.low = {kFar, kFar, kFar}, .high = {-kFar, -kFar, -kFar}};
  for (const auto& place : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min(bounds.low[axis], place[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], place[axis]);
    }
  }
  if (points.empty()) bounds = {.low = {-1, -1, -1}, .high = {1, 1, 1}};
  return bounds;
}

// Rotates v by the shortest rotation from the z axis to `up`, a unit vector.
Vec3 turned(const Vec3& v, const Vec3& up) {
  constexpr Vec3 kZ = {0, 0, 1};
  const double cosine = dot(kZ, up);
  if (cosine < -1 + 1e-9) return {-v[0], v[1], -v[2]};
  // Rodrigues' formula; `axis` includes the sine.
  const Vec3 axis = cross(kZ, up);
  const Vec3 across = sum(scaled(v, cosine), cross(axis, v));
  return moved(across, dot(axis, v) / (1 + cosine), axis);
}

}  // namespace

Vec3 Camera::seen(const Vec3& place) const {
  const Vec3 from_eye = difference(place, eye);
  return {dot(from_eye, right), dot(from_eye, up), dot(from_eye, back)};
}

Camera framing(std::span<const Vec3> points, double azimuth, double elevation, int width,
               int height, const Vec3& up) {
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
  for (Vec3* direction : {&camera.right, &camera.up, &camera.back}) {
    *direction = turned(*direction, up);
  }
  const Bounds bounds = bounds_of(points);
  Vec3 middle;
  double radius = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    middle[axis] = (bounds.low[axis] + bounds.high[axis]) / 2;
    radius = std::max(radius, (bounds.high[axis] - bounds.low[axis]) / 2);
  }
  if (radius == 0) radius = 1;
  // A place is in view if the eye is at least this far from the center: the place's depth in front
  // of the center plus its offset to the side or up, divided by these slopes.
  const double across = kFilled * width / (2 * camera.pixels_at_one);
  const double upwards = kFilled * height / (2 * camera.pixels_at_one);
  double distance = points.empty() ? 4 * radius : 0;
  for (const auto& place : points) {
    const Vec3 from_middle = difference(place, middle);
    const double needed = std::max(std::abs(dot(from_middle, camera.right)) / across,
                                   std::abs(dot(from_middle, camera.up)) / upwards);
    distance = std::max(distance, dot(from_middle, camera.back) + std::max(needed, 0.1 * radius));
  }
  camera.distance = distance;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    camera.eye[axis] = middle[axis] + distance * camera.back[axis];
  }
  return camera;
}

std::optional<Vec3> up_axis_from(std::string_view text) {
  const double sign = text.starts_with('-') ? -1 : 1;
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t axis = std::string_view("xyz").find(text);
  if (text.size() != 1 || axis == std::string_view::npos) return std::nullopt;
  Vec3 up = {0, 0, 0};
  up[axis] = sign;
  return up;
}

}  // namespace multitetra
