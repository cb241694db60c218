#include "common/mesh/surface_distance.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

// Of a point from a segment; both as differences from the segment's start.
double squared_distance_to_segment(const Vec3& point, const Vec3& segment) {
  const double length = dot(segment, segment);
  const double t = length > 0 ? std::clamp(dot(point, segment) / length, 0.0, 1.0) : 0.0;
  const Vec3 rest = difference(point, scaled(segment, t));
  return dot(rest, rest);
}

// Squared sine of the angle below which a triangle is too thin to have a reliable plane.
constexpr double kThin = 1e-16;

// Returns the squared distance to the plane if the perpendicular's foot lies inside, otherwise to
// the nearest of the sides that have it on their outer side. A thin triangle counts as its sides.
double squared_distance_to_triangle(const Vec3& p, const SurfaceTriangle& t) {
  const std::array<Vec3, 3> side = {difference(t[1], t[0]), difference(t[2], t[1]),
                                    difference(t[0], t[2])};
  const Vec3 normal = cross(side[2], side[0]);
  const double area = dot(normal, normal);
  const bool is_thin = !(area > kThin * dot(side[0], side[0]) * dot(side[2], side[2]));
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 from_start = difference(p, t[i]);
    if (is_thin || !(dot(cross(side[i], from_start), normal) > 0)) {
      nearest = std::min(nearest, squared_distance_to_segment(from_start, side[i]));
    }
  }
  if (nearest < std::numeric_limits<double>::infinity()) return nearest;
  const double height = dot(difference(p, t[0]), normal);
  return height * height / area;
}

double area_of(const SurfaceTriangle& t) {
  const Vec3 normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
  return 0.5 * std::sqrt(dot(normal, normal));
}

// SplitMix64: numbers in [0, 1) from 53 bits, the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ += 0x9E3779B97F4A7C15;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }

 private:
  std::uint64_t state_;
};

// Returns a uniformly distributed point: one of the parallelogram, folded at the diagonal.
Vec3 point_in(const SurfaceTriangle& t, Random& random) {
  double u = random();
  double v = random();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  Vec3 point;
  for (std::size_t i = 0; i < 3; ++i) {
    point[i] = t[0][i] + u * (t[1][i] - t[0][i]) + v * (t[2][i] - t[0][i]);
  }
  return point;
}

std::vector<Box3> boxes_of(std::span<const SurfaceTriangle> triangles) {
  std::vector<Box3> boxes(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const Vec3& corner : triangles[i]) boxes[i].add(corner);
  }
  return boxes;
}

}  // namespace

double distance_to_triangle(const Vec3& point, const SurfaceTriangle& triangle) {
  return std::sqrt(squared_distance_to_triangle(point, triangle));
}

std::vector<Vec3> sampled_points(std::span<const SurfaceTriangle> surface, std::size_t count,
                                 std::uint64_t seed) {
  double whole = 0;
  for (const SurfaceTriangle& triangle : surface) whole += area_of(triangle);
  std::vector<Vec3> points;
  if (!(whole > 0) || count == 0) return points;
  points.reserve(count);
  Random random(seed);
  const double part = whole / static_cast<double>(count);
  const auto next_place = [&] { return part * (static_cast<double>(points.size()) + random()); };
  double passed = 0;
  double place = next_place();
  for (const SurfaceTriangle& triangle : surface) {
    passed += area_of(triangle);
    while (points.size() < count && place < passed) {
      points.push_back(point_in(triangle, random));
      place = next_place();
    }
  }
  return points;
}

NearestTriangle::NearestTriangle(std::span<const SurfaceTriangle> triangles,
                                 const std::stop_token& stop)
    : tree_(boxes_of(triangles), stop) {
  triangles_.reserve(triangles.size());
  for (const std::uint32_t number : tree_.order()) triangles_.push_back(triangles[number]);
}

NearestTriangle::Found NearestTriangle::nearest(const Vec3& point,
                                                const SurfaceTriangle* near) const {
  if (triangles_.empty()) return {};
  const auto squared_distance = [&](std::uint32_t place) {
    return squared_distance_to_triangle(point, triangles_[place]);
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  BoxTree::Nearest found;
  if (near != nullptr) {
    const double at_most = squared_distance_to_triangle(point, *near);
    found = tree_.nearest(point, squared_distance, std::nextafter(at_most, kInfinity));
  }
  // By rounding, a triangle may seem nearer than its box.
  if (found.place >= triangles_.size()) found = tree_.nearest(point, squared_distance);
  return {std::sqrt(found.squared_distance), &triangles_[found.place], tree_.order()[found.place]};
}

}  // namespace multitetra
