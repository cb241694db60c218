// Bounds the two-sided Hausdorff distance of a surface from the one it was simplified from by one
// number per vertex: faster but looser than successive_mapping.hpp.
//
// The argument. The *error* at a point of the simplified surface N is linear in each triangle, so
// one number per vertex bounds it. Points of the original M correspond to points of N, every point
// to at least one on the other surface, and the distance between corresponding x and y is at most
// the error at y. So no point of either surface is farther from the other than the largest error.
//
// A collapse preserves this in one of two ways.
//
//  * Linear: u moves onto v, and the triangles around u move with it, linearly. A point of a
//    triangle with the barycentric coordinate l of u moves by l |uv|. So it suffices to raise the
//    error at v to |uv| + the error at u. (Edge contraction is a simplicial map.)
//  * As a map between two discs: u is placed where the fan is nearest, and the edges from it to its
//    ring are drawn in the fan, across the spokes (terms as in successive_mapping.hpp). Where one
//    crosses a spoke, the nearest points of the two in space correspond, and so do u and its place.
//    These points divide the old and the new triangles into the same pieces, between which the
//    correspondence is linear. Distances are convex functions there and errors are linear: so it
//    suffices that at these pairs the new error is at least the distance plus the old error. To
//    this end, errors at the ends of a spoke, or at the corners of the triangle that contains u's
//    place, are raised.
//
// Unchanged triangles keep their corresponding points; a raised error only loosens their bound.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec3.hpp"

namespace multitetra {

class VertexErrors {
 public:
  VertexErrors(std::span<const Vec3> positions)
      : positions_(positions), errors_(positions.size()) {}

  // Returns whether u can collapse onto w_0 with all errors in the fan at most `limit`. Changes
  // nothing. `ring` is w_0, w_1, ... around u, `ring_positions` their positions.
  [[nodiscard]] bool fits(std::uint32_t u, std::span<const std::uint32_t> ring,
                          std::span<const Vec3> ring_positions, double limit);
  // Applies the collapse that was accepted last.
  void commit();

  [[nodiscard]] double operator[](std::uint32_t vertex) const { return errors_[vertex]; }

 private:
  // A point of the fan, by barycentric coordinates in one sector.
  struct Place {
    std::uint32_t sector = 1;
    double at_v = 0, at_first = 0, at_second = 0;
    double squared_distance = 0;
  };
  [[nodiscard]] static Place nearest(const Vec3& point, std::span<const Vec3> ring);
  // Raises these errors to the lowest common level at which their weighted mean is `least`.
  struct Weighted {
    std::uint32_t index = 0;
    double weight = 0;
  };
  void raise(std::span<const Weighted> corners, double least);
  [[nodiscard]] bool fits_as_map(const Vec3& point, double error,
                                 std::span<const Vec3> ring_positions, double limit);

  std::span<const Vec3> positions_;
  std::vector<double> errors_;
  // State of one collapse: the ring, its errors before and after, and the largest raised error.
  std::span<const std::uint32_t> ring_;
  std::vector<double> before_, after_;
  double raised_ = 0;
};

}  // namespace multitetra
