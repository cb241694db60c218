// Sums of squared distances to planes, as a function of a point (M. Garland, P. Heckbert, "Surface
// simplification using quadric error metrics", SIGGRAPH 1997).
#pragma once

#include "common/affine.hpp"
#include "server/core/vectors.hpp"

namespace multitetra {

// x -> x A x + 2 b x + c, A symmetric.
struct Quadric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  Vec3 b = {0, 0, 0};
  double c = 0;

  // The plane of a triangle, as often as its area says.
  [[nodiscard]] static Quadric of_triangle(const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 n = vector_product(difference(q, p), difference(r, p));
    const double squared = squared_length(n);
    if (!(squared > 0)) return {};
    const double weight = 1 / std::sqrt(squared);  // The area (twice), over the squared length.
    const double d = -inner_product(n, p);
    Quadric quadric{.xx = weight * n[0] * n[0],
                    .yy = weight * n[1] * n[1],
                    .zz = weight * n[2] * n[2],
                    .xy = weight * n[0] * n[1],
                    .xz = weight * n[0] * n[2],
                    .yz = weight * n[1] * n[2],
                    .b = moved({0, 0, 0}, weight * d, n),
                    .c = weight * d * d};
    return quadric;
  }
  void add(const Quadric& o) {
    xx += o.xx;
    yy += o.yy;
    zz += o.zz;
    xy += o.xy;
    xz += o.xz;
    yz += o.yz;
    b = {b[0] + o.b[0], b[1] + o.b[1], b[2] + o.b[2]};
    c += o.c;
  }
  [[nodiscard]] double at(const Vec3& p) const {
    const double x = p[0], y = p[1], z = p[2];
    return x * (xx * x + 2 * (xy * y + xz * z + b[0])) + y * (yy * y + 2 * (yz * z + b[1])) +
           z * (zz * z + 2 * b[2]) + c;
  }
};

}  // namespace multitetra
