#include "common/mesh/surface_distance.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kMaxTrianglesInLeaf = 4;

double squared_distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = difference(b, a);
  const Vec3 ap = difference(p, a);
  const double length = dot(ab, ab);
  const double t = length > 0 ? std::clamp(dot(ap, ab) / length, 0.0, 1.0) : 0.0;
  const Vec3 rest = {ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2]};
  return dot(rest, rest);
}

// To the plane where the foot of the perpendicular lies inside, else to the nearest side. A
// triangle so thin that its plane is uncertain is taken for its sides.
double squared_distance_to_triangle(const Vec3& p, const SurfaceTriangle& t) {
  const Vec3 normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
  const double area = dot(normal, normal);
  bool is_inside = area > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& a = t[i];
    const Vec3& b = t[(i + 1) % 3];
    is_inside = is_inside && dot(cross(difference(b, a), difference(p, a)), normal) > 0;
    nearest = std::min(nearest, squared_distance_to_segment(p, a, b));
  }
  if (!is_inside) return nearest;
  const double height = dot(difference(p, t[0]), normal);
  return std::min(nearest, height * height / area);
}

double area_of(const SurfaceTriangle& t) {
  const Vec3 normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
  return 0.5 * std::sqrt(dot(normal, normal));
}

// SplitMix64: a number in [0, 1) from 53 bits, the same with every standard library.
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

// Evenly over the triangle: a point of the parallelogram, folded over the diagonal.
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

double centre(const SurfaceTriangle& t, std::size_t axis) {
  return t[0][axis] + t[1][axis] + t[2][axis];  // Three times it, which orders the same.
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

NearestTriangle::NearestTriangle(std::vector<SurfaceTriangle> triangles)
    : triangles_(std::move(triangles)) {
  assert(triangles_.size() < std::numeric_limits<std::uint32_t>::max());
  nodes_.reserve(triangles_.size());
  if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()));
}

// Splits at the median along the longest side, so the depth is the logarithm of the number.
void NearestTriangle::build(std::uint32_t first, std::uint32_t last) {
  Node node{.low = triangles_[first][0], .high = triangles_[first][0]};
  for (std::uint32_t i = first; i < last; ++i) {
    for (const Vec3& corner : triangles_[i]) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.low[axis] = std::min(node.low[axis], corner[axis]);
        node.high[axis] = std::max(node.high[axis], corner[axis]);
      }
    }
  }
  const std::size_t self = nodes_.size();
  nodes_.push_back(node);
  if (last - first <= kMaxTrianglesInLeaf) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return;
  }
  const Vec3 size = difference(node.high, node.low);
  const auto axis =
      static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(triangles_.begin() + first, triangles_.begin() + middle,
                   triangles_.begin() + last,
                   [axis](const SurfaceTriangle& a, const SurfaceTriangle& b) {
                     return centre(a, axis) < centre(b, axis);
                   });
  build(first, middle);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(middle, last);
}

double NearestTriangle::squared_distance(const Vec3& point, const Node& box) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double outside =
        std::max({box.low[axis] - point[axis], point[axis] - box.high[axis], 0.0});
    sum += outside * outside;
  }
  return sum;
}

double NearestTriangle::distance(const Vec3& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  if (nodes_.empty()) return nearest;
  struct Waiting {
    std::uint32_t node;
    double distance;  // Squared, to its box.
  };
  std::array<Waiting, 64> waiting;  // One for each level at most: there are fewer than 33.
  std::size_t count = 0;
  waiting[count++] = {0, squared_distance(point, nodes_[0])};
  while (count > 0) {
    const Waiting next = waiting[--count];
    if (next.distance >= nearest) continue;
    const Node& node = nodes_[next.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        nearest = std::min(nearest, squared_distance_to_triangle(point, triangles_[i]));
      }
      continue;
    }
    Waiting near = {next.node + 1, squared_distance(point, nodes_[next.node + 1])};
    Waiting far = {node.first, squared_distance(point, nodes_[node.first])};
    if (far.distance < near.distance) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
  return std::sqrt(nearest);
}

DistanceStatistics distances(std::span<const Vec3> points, const NearestTriangle& surface,
                             const DistanceLimit& limit) {
  DistanceStatistics statistics{.samples = points.size()};
  if (points.empty()) return statistics;
  std::vector<double> all;
  all.reserve(points.size());
  double sum = 0;
  double worst_excess = -std::numeric_limits<double>::infinity();
  for (const Vec3& point : points) {
    const double distance = surface.distance(point);
    const double allowed = limit(point);
    all.push_back(distance);
    sum += distance;
    if (distance > allowed) ++statistics.above_limit;
    if (distance - allowed > worst_excess) {
      worst_excess = distance - allowed;
      statistics.worst_distance = distance;
      statistics.worst_limit = allowed;
      statistics.worst_place = point;
    }
  }
  statistics.mean = sum / static_cast<double>(points.size());
  statistics.maximum = *std::max_element(all.begin(), all.end());
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(points.size())) - 1);
  std::nth_element(all.begin(), all.begin() + rank, all.end());
  statistics.percentile_99 = all[static_cast<std::size_t>(rank)];
  return statistics;
}

}  // namespace multitetra
