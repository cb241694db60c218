// Bounds the distance of a surface from the one it was simplified from, by one number a vertex:
// fast, and larger than what successive_mapping.hpp finds.
//
// The argument. The *error* at a point of the simplified surface N is linear in each triangle, so
// one number a vertex bounds it. Points of the original M belong to points of N, at least one to
// each on either side, and where x belongs to y the distance between them is at most the error at
// y. So no point of either surface is farther from the other than the largest error.
//
// A collapse keeps that in one of two ways.
//
//  * Straight: u moves onto v, and with it the triangles around u, linearly. A point of a triangle
//    that has the share l of u moves by l |uv|. So it is enough that the error at v becomes
//    |uv| + the error at u, if that is more than it was. (The edge contraction is a simplicial
//    map.)
//  * As a map of one disc onto another: u is placed where the fan is nearest, and the edges from it
//    to its ring are drawn in the fan, across the spokes (the words are those of
//    successive_mapping.hpp). Where one crosses a spoke, the nearest points of the two in space
//    belong to each other, and so do u and its place. These points cut the old triangles and the
//    new ones into the same pieces, and what belongs to what is linear between them. A distance is
//    a convex function of it and errors are linear: so it is enough that in the pairs named
//    the new error is at least the distance and the old error together. Errors at the ends of a
//    spoke, or at the corners of the triangle that u is placed in, are raised until it is.
//
// Triangles that stay keep the points that belonged to them; where a vertex of theirs has its error
// raised, these points are only nearer than the error.
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

  // Whether u can collapse onto w_0 without an error in the fan above `limit`: nothing is changed
  // yet. `ring` is w_0, w_1, ... around u, `places` where they are.
  [[nodiscard]] bool fits(std::uint32_t u, std::span<const std::uint32_t> ring,
                          std::span<const Vec3> places, double limit);
  // Makes the errors as they are after the collapse that was last found to fit.
  void keep();

  [[nodiscard]] double operator[](std::uint32_t vertex) const { return errors_[vertex]; }

 private:
  // A point of the fan by its share of three corners of the ring.
  struct Place {
    std::uint32_t sector = 1;
    double at_v = 0, at_first = 0, at_second = 0;
    double squared_distance = 0;
  };
  [[nodiscard]] static Place nearest(const Vec3& point, std::span<const Vec3> ring);
  // Raises errors of the fan, each to the same least level, until their mean with these weights is
  // `least`.
  struct Weighted {
    std::uint32_t index = 0;
    double weight = 0;
  };
  void raise(std::span<const Weighted> corners, double least);
  [[nodiscard]] bool fits_as_map(const Vec3& point, double error, std::span<const Vec3> places,
                                 double limit);

  std::span<const Vec3> positions_;
  std::vector<double> errors_;
  // For one collapse: the ring, the errors there before and after, and the largest that was raised.
  std::span<const std::uint32_t> ring_;
  std::vector<double> before_, after_;
  double raised_ = 0;
};

}  // namespace multitetra
