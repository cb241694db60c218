// The triangles that a vertex gets in a collapse, as geometry: how near points and edges of another
// surface are to them. The words are those of successive_mapping.hpp.
//
// Points and edges count as farther away than they are, by the errors of their vertices: how far
// the surface that they belong to is from the one before it (see vertex_errors.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/affine.hpp"

namespace multitetra {

class CollapseFan {
 public:
  // A vertex or a place on an edge, and its error. Half a cache line.
  struct alignas(32) Point {
    Vec3 at = {};
    double error = 0;
  };

  // Prepares the fan of v = w_0 with the ring w_0, w_1, ..., of three vertices at least. No
  // distance above `limit` counts as near.
  void set_up(std::span<const Vec3> ring, double limit);

  [[nodiscard]] std::uint32_t sectors() const { return sectors_; }
  // The largest distance that counted as near since set_up, with the errors.
  [[nodiscard]] double largest() const { return largest_; }

  // The sector that a point is straight above of, or else the nearest; nullopt when none is near.
  [[nodiscard]] std::optional<std::uint32_t> sector_near(const Point& point);
  // Whether the edge from `low` to `high` is near to the spokes first .. last.
  [[nodiscard]] bool is_near(const Point& low, const Point& high, std::uint32_t first,
                             std::uint32_t last);
  // Whether it is near to an edge at the fan's border, which is from `begin` to `end`.
  [[nodiscard]] bool is_near_rim(const Point& low, const Point& high, const Vec3& begin,
                                 const Vec3& end);
  // Whether a vertex that stays has an error within the limit.
  [[nodiscard]] bool is_near(double error);

 private:
  // The squared sine of a triangle: a thinner one has no normal to measure heights along.
  static constexpr double kThinnest = 1e-12;

  struct FanEdge {
    Vec3 along;
    double squared_length = 0;
    double inverse = 0;  // 1 / squared_length
  };
  struct Triangle {
    Vec3 first, second;  // Dual to its edges from v.
    Vec3 normal;
    double inverse = 0;  // 1 / the normal's squared length; 0 of a thin triangle.
  };
  // An edge, seen from where a spoke begins.
  struct SeenEdge {
    SeenEdge(const Point& low, const Point& high, const Vec3& from);

    Vec3 low;
    Vec3 along;
    double squared_length;
    double low_along;  // dot(low, along)
    // The error at the low end.
    double error;
    // The difference of the errors at the high and the low end.
    double rise;
  };

  [[nodiscard]] bool is_near(const SeenEdge& edge, const FanEdge& spoke);

  std::uint32_t sectors_ = 0;
  Vec3 apex_ = {0, 0, 0};
  double limit_ = 0;
  double largest_ = 0;
  std::vector<FanEdge> spokes_;      // From 1 on.
  std::vector<Triangle> triangles_;  // From 1 on.
};

}  // namespace multitetra
