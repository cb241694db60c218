// Sums of squared distances to planes as a function of a point (M. Garland, P. Heckbert, "Surface
// simplification using quadric error metrics", SIGGRAPH 1997). Each has an origin of its own, near
// which single precision suffices. Quadrics only order collapses; no bound depends on them.
#pragma once

#include <cmath>

#include "common/base/affine.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {

// x -> x A x + 2 b x + c, A symmetric; x is relative to the origin.
struct Quadric {
  float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  float bx = 0, by = 0, bz = 0;
  float c = 0;

  // Returns the quadric of the plane through the origin with normal n, weighted by the length of n.
  [[nodiscard]] static Quadric of_plane(const Vec3& n) {
    const double squared = squared_length(n);
    if (!(squared > 0)) return {};
    const double weight = 1 / std::sqrt(squared);
    const auto part = [&](double a, double b) { return static_cast<float>(weight * a * b); };
    return {.xx = part(n[0], n[0]),
            .yy = part(n[1], n[1]),
            .zz = part(n[2], n[2]),
            .xy = part(n[0], n[1]),
            .xz = part(n[0], n[2]),
            .yz = part(n[1], n[2])};
  }
  // Returns the sum of the planes' weights.
  [[nodiscard]] float weight() const { return xx + yy + zz; }
  void add(const Quadric& o) {
    xx += o.xx;
    yy += o.yy;
    zz += o.zz;
    xy += o.xy;
    xz += o.xz;
    yz += o.yz;
    bx += o.bx;
    by += o.by;
    bz += o.bz;
    c += o.c;
  }
  // Returns the same function relative to `origin`.
  [[nodiscard]] Quadric relative_to(const Vec3& origin) const {
    const auto x = static_cast<float>(origin[0]);
    const auto y = static_cast<float>(origin[1]);
    const auto z = static_cast<float>(origin[2]);
    Quadric moved = *this;
    moved.bx += xx * x + xy * y + xz * z;
    moved.by += xy * x + yy * y + yz * z;
    moved.bz += xz * x + yz * y + zz * z;
    moved.c = at(origin);
    return moved;
  }
  [[nodiscard]] float at(const Vec3& p) const {
    const auto x = static_cast<float>(p[0]);
    const auto y = static_cast<float>(p[1]);
    const auto z = static_cast<float>(p[2]);
    return x * (xx * x + 2 * (xy * y + xz * z + bx)) + y * (yy * y + 2 * (yz * z + by)) +
           z * (zz * z + 2 * bz) + c;
  }
};

}  // namespace multitetra
