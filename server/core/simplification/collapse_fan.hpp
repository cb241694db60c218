// The triangles that a vertex gets in a collapse, as geometry: how near points and edges of another
// surface are to them. The words are those of successive_mapping.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/affine.hpp"

namespace multitetra {

class CollapseFan {
 public:
  // Of v = w_0 with the ring w_0, w_1, ..., of three vertices at least. No squared distance above
  // `squared_limit` counts as near.
  void set_up(std::span<const Vec3> ring, double squared_limit);

  [[nodiscard]] std::uint32_t sectors() const { return sectors_; }
  // Of the largest distance that counted as near since set_up.
  [[nodiscard]] double largest_squared() const { return largest_; }

  // The sector that a point is straight above of, or else the nearest; nullopt when none is near.
  [[nodiscard]] std::optional<std::uint32_t> sector_near(const Vec3& point);
  // Whether the edge from `low` to `high` is near to the spokes first .. last.
  [[nodiscard]] bool is_near(const Vec3& low, const Vec3& high, std::uint32_t first,
                             std::uint32_t last);

 private:
  // Of a triangle's sine, squared: a thinner one has no normal to measure heights along.
  static constexpr double kThinnest = 1e-12;

  struct Spoke {
    Vec3 along;
    double squared_length = 0;
    double inverse = 0;  // 1 / squared_length
  };
  struct Triangle {
    Vec3 first, second;  // Dual to its edges from v.
    Vec3 normal;
    double inverse = 0;  // 1 / the normal's squared length; 0 of a thin triangle.
  };

  std::uint32_t sectors_ = 0;
  Vec3 apex_ = {0, 0, 0};
  double squared_limit_ = 0;
  double largest_ = 0;
  std::vector<Spoke> spokes_;        // From 1 on.
  std::vector<Triangle> triangles_;  // From 1 on.
};

}  // namespace multitetra
