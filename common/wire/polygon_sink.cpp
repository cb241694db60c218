#include "common/wire/polygon_sink.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

namespace multitetra {
namespace {

using Place = std::array<double, 2>;

// Returns twice the signed area of a triangle.
double turn(const Place& a, const Place& b, const Place& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// A polygon as seen along its mean normal, counterclockwise. Corners are numbered along it.
class FlatPolygon {
 public:
  explicit FlatPolygon(const std::vector<Vec3>& corners) {
    Vec3 normal = {0, 0, 0};  // By Newell's sum over edges.
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 from = difference(corners[i], corners[0]);
      const Vec3 to = difference(corners[(i + 1) % corners.size()], corners[0]);
      normal = sum(normal, cross(from, to));
    }
    std::size_t along = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (std::abs(normal[axis]) > std::abs(normal[along])) along = axis;
    }
    std::size_t right = (along + 1) % 3;
    std::size_t up = (along + 2) % 3;
    if (normal[along] < 0) std::swap(right, up);
    places_.reserve(corners.size());
    for (const Vec3& corner : corners) {
      for (const double coordinate : corner) {
        rounding_ = std::max(rounding_, 0x1p-23 * std::abs(coordinate));
      }
      const Vec3 place = difference(corner, corners[0]);
      places_.push_back({place[right], place[up]});
    }
  }

  // Returns whether it turns left or not at all at each corner, and around once.
  [[nodiscard]] bool is_convex() const {
    const std::size_t count = places_.size();
    double angles = 0;
    Place into = {};                               // The last edge that has a length.
    for (std::size_t i = 0; i < 2 * count; ++i) {  // Twice, for the edge before the first.
      const Place& from = places_[i % count];
      const Place& to = places_[(i + 1) % count];
      const Place edge = {to[0] - from[0], to[1] - from[1]};
      if (edge == Place{}) continue;
      const double area = into[0] * edge[1] - into[1] * edge[0];
      if (area < -tolerance(into, edge)) return false;
      if (i >= count) angles += std::atan2(area, into[0] * edge[0] + into[1] * edge[1]);
      into = edge;
    }
    return angles < 3 * std::numbers::pi;  // Twice around are 4 pi.
  }

  // Returns whether the triangle of three corners turns left and no other of `corners` is in it, or
  // on its border if `with_border`.
  [[nodiscard]] bool is_ear(const std::array<std::uint32_t, 3>& ear,
                            const std::vector<std::uint32_t>& corners, bool with_border) const {
    const auto [a, b, c] = std::array{places_[ear[0]], places_[ear[1]], places_[ear[2]]};
    if (!(turn(a, b, c) > 0)) return false;
    return std::none_of(corners.begin(), corners.end(), [&](std::uint32_t corner) {
      const Place& p = places_[corner];
      if (p == a || p == b || p == c) return false;
      const double least = std::min({turn(a, b, p), turn(b, c, p), turn(c, a, p)});
      return with_border ? least >= 0 : least > 0;
    });
  }

  // Returns 1 if the corners turn left, -1 if right, and 0 if the rounding of their coordinates to
  // 32-bit floats decides.
  [[nodiscard]] int turn_at(const std::array<std::uint32_t, 3>& ear) const {
    const auto [a, b, c] = std::array{places_[ear[0]], places_[ear[1]], places_[ear[2]]};
    const double area = turn(a, b, c);
    const double rounded = tolerance({b[0] - a[0], b[1] - a[1]}, {c[0] - b[0], c[1] - b[1]});
    return area > rounded ? 1 : area < -rounded ? -1 : 0;
  }

 private:
  [[nodiscard]] double tolerance(const Place& a, const Place& b) const {
    return rounding_ * (std::abs(a[0]) + std::abs(a[1]) + std::abs(b[0]) + std::abs(b[1]));
  }

  std::vector<Place> places_;
  double rounding_ = 0;  // Of a coordinate.
};

using Triple = std::array<std::uint32_t, 3>;

std::vector<Triple> fan(std::size_t corners) {
  std::vector<Triple> triangles;
  for (std::uint32_t i = 2; i < corners; ++i) triangles.push_back({0, i - 1, i});
  return triangles;
}

// Returns triangles of corners. A polygon without an area becomes a fan, and so does a
// quadrilateral without an ear: warped ones of other programs may look crossed. `comparisons` is
// how many corners may still be compared with ears; those that are count down.
std::vector<Triple> cut(const FlatPolygon& polygon, std::size_t count, std::uint64_t& comparisons) {
  std::vector<std::uint32_t> left(count);
  for (std::uint32_t i = 0; i < count; ++i) left[i] = i;
  std::vector<Triple> triangles;
  const auto corners_at = [&](std::size_t i) {
    return Triple{left[(i + left.size() - 1) % left.size()], left[i], left[(i + 1) % left.size()]};
  };
  while (left.size() > 3) {
    std::size_t ear = left.size();
    for (const bool with_border : {true, false}) {
      for (std::size_t i = 1; ear == left.size() && i <= left.size(); ++i) {
        const std::size_t at = i % left.size();
        if (comparisons < left.size()) {
          throw MeshFileError("its concave faces have so many corners that they take too long");
        }
        comparisons -= left.size();
        if (polygon.is_ear(corners_at(at), left, with_border)) ear = at;
      }
    }
    if (ear == left.size()) {  // Only corners on lines are left, or the polygon crosses itself.
      for (std::size_t i = 1; ear == left.size() && i < left.size(); ++i) {
        if (polygon.turn_at(corners_at(i)) == 0) ear = i;
      }
    }
    if (ear == left.size()) break;
    triangles.push_back(corners_at(ear));
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  const bool is_cut = left.size() == 3 && polygon.turn_at({left[0], left[1], left[2]}) >= 0;
  if (!is_cut && count == 4) return fan(count);
  if (!is_cut) {
    throw MeshFileError("a face of " + std::to_string(count) +
                        " corners crosses itself, so what it covers is unknown");
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace

void PolygonSink::add(std::int64_t vertex) {
  if (vertex < 0 || vertex >= static_cast<std::int64_t>(mesh_.vertices.size())) {
    throw MeshFileError("a face has the vertex " + std::to_string(vertex) + " of " +
                        std::to_string(mesh_.vertices.size()));
  }
  if (corners_.size() >= kMaxPolygonCorners) {
    throw MeshFileError("a face has more than " + std::to_string(kMaxPolygonCorners) + " corners");
  }
  corners_.push_back(static_cast<std::uint32_t>(vertex));
}

void PolygonSink::end() {
  if (corners_.size() < 3) return;
  if (corners_.size() == 3) {
    mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
    return;
  }
  std::vector<Vec3> places;
  places.reserve(corners_.size());
  for (const std::uint32_t corner : corners_) places.push_back(mesh_.vertices[corner]);
  const FlatPolygon polygon(places);
  const bool is_convex = polygon.is_convex();
  for (const Triple& t :
       is_convex ? fan(corners_.size()) : cut(polygon, corners_.size(), comparisons_left_)) {
    mesh_.triangles.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
  }
}

}  // namespace multitetra
