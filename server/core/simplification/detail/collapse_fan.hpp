// The triangles that a vertex gets in a collapse, as geometry: measures how near points and edges
// of another surface are to them. Terms as in successive_mapping.hpp.
//
// Distances of points and edges include the errors of their vertices: bounds of the distance of
// their surface from the one before it (see vertex_errors.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/affine.hpp"

namespace multitetra {

class CollapseFan {
 public:
  // A vertex or a point on an edge, and its error. Half a cache line.
  struct alignas(32) Point {
    Vec3 at = {};
    double error = 0;
  };

  // Sets up the fan of v = w_0 with the ring w_0, w_1, ..., which has at least three vertices.
  // Distances above `limit` are not near.
  void set_up(std::span<const Vec3> ring, double limit);

  [[nodiscard]] std::uint32_t sectors() const { return sectors_; }
  // Returns the largest distance, errors included, accepted as near since set_up.
  [[nodiscard]] double largest() const { return largest_; }

  // Returns the sector whose triangle a point projects onto or, if there is none, the nearest;
  // nullopt if none is near.
  [[nodiscard]] std::optional<std::uint32_t> sector_near(const Point& point);
  // Returns whether the edge from `low` to `high` is near the spokes first .. last.
  [[nodiscard]] bool is_near(const Point& low, const Point& high, std::uint32_t first,
                             std::uint32_t last);
  // Returns whether the edge is near the edge of the fan's border from `begin` to `end`.
  [[nodiscard]] bool is_near_rim(const Point& low, const Point& high, const Vec3& begin,
                                 const Vec3& end);
  // Returns whether the error of a vertex that stays is within the limit.
  [[nodiscard]] bool is_near(double error);

 private:
  // The squared sine below which a triangle has no usable normal.
  static constexpr double kMinSquaredSine = 1e-12;

  struct FanEdge {
    Vec3 along;
    double squared_length = 0;
    double inverse = 0;  // 1 / squared_length
  };
  struct Triangle {
    Vec3 first, second;  // Dual to the triangle's edges from v.
    Vec3 normal;
    double inverse = 0;  // 1 / the normal's squared length; 0 for a thin triangle.
  };
  // An edge relative to the origin of a spoke.
  struct RelativeEdge {
    RelativeEdge(const Point& low, const Point& high, const Vec3& from);

    Vec3 low;
    Vec3 along;
    double squared_length;
    // dot(low, along).
    double low_along;
    // Error at the low end.
    double error;
    // Error at the high end minus that at the low end.
    double rise;
  };

  [[nodiscard]] bool is_near(const RelativeEdge& edge, const FanEdge& spoke);

  std::uint32_t sectors_ = 0;
  Vec3 apex_ = {0, 0, 0};
  double limit_ = 0;
  double largest_ = 0;
  std::vector<FanEdge> spokes_;      // Indices start at 1.
  std::vector<Triangle> triangles_;  // Indices start at 1.
};

}  // namespace multitetra
