#include "server/certify/detail/exact_predicates.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include <boost/multiprecision/cpp_int.hpp>

namespace multitetra {
namespace {

// Bounds of the errors of the determinants below in double, relative to the sums of their terms'
// magnitudes (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust
// geometric predicates"). They hold as long as nothing underflows.
constexpr double kEpsilon = 0x1p-53;
constexpr double kError3 = (7 + 56 * kEpsilon) * kEpsilon;
constexpr double kError2 = (3 + 16 * kEpsilon) * kEpsilon;
constexpr double kLeastMagnitude = 1e-250;

int sign(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// The sign of a determinant in double, if its error does not matter.
std::optional<int> certain_sign(double determinant, double magnitude, double error) {
  if (magnitude == 0) return std::nullopt;  // It may have underflowed.
  if (magnitude > kLeastMagnitude && std::abs(determinant) > error * magnitude) {
    return sign(determinant);
  }
  return std::nullopt;
}

// The coordinates times one power of two as integers below 2^62; none where they differ too much in
// magnitude. What their differences' products sum up to has less than 200 bits.
template <std::size_t count>
std::optional<std::array<std::int64_t, count>> as_integers(
    const std::array<double, count>& coordinates) {
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();
  for (const double v : coordinates) {
    if (v == 0) continue;
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(v, &exponent), 53));
    lowest =
        std::min(lowest, exponent - 53 + std::countr_zero(static_cast<std::uint64_t>(mantissa)));
    highest = std::max(highest, exponent);
  }
  std::array<std::int64_t, count> integers{};
  if (highest < lowest) return integers;
  if (highest - lowest > 61) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i) {
    integers[i] = static_cast<std::int64_t>(std::ldexp(coordinates[i], -lowest));
  }
  return integers;
}

// Rows of differences to the last point.
template <typename Number, typename Coordinate>
Number determinant(const std::array<Coordinate, 12>& p) {
  const auto d = [&](std::size_t point, std::size_t axis) -> Number {
    return Number(p[3 * point + axis]) - Number(p[9 + axis]);
  };
  const auto minor = [&](std::size_t i, std::size_t j) -> Number {
    return d(i, 0) * d(j, 1) - d(j, 0) * d(i, 1);
  };
  return d(0, 2) * minor(1, 2) + d(1, 2) * minor(2, 0) + d(2, 2) * minor(0, 1);
}

template <typename Number, typename Coordinate>
Number determinant(const std::array<Coordinate, 6>& p) {
  const auto d = [&](std::size_t point, std::size_t axis) -> Number {
    return Number(p[2 * point + axis]) - Number(p[4 + axis]);
  };
  return d(0, 0) * d(1, 1) - d(1, 0) * d(0, 1);
}

template <std::size_t count>
int exact_sign(const std::array<double, count>& coordinates) {
  using boost::multiprecision::cpp_rational;
  using boost::multiprecision::int256_t;
  if (const auto integers = as_integers(coordinates)) {
    return determinant<int256_t>(*integers).sign();
  }
  return determinant<cpp_rational>(coordinates).sign();
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = difference(a, d);
  const Vec3 v = difference(b, d);
  const Vec3 w = difference(c, d);
  const double vw = v[0] * w[1];
  const double wv = w[0] * v[1];
  const double wu = w[0] * u[1];
  const double uw = u[0] * w[1];
  const double uv = u[0] * v[1];
  const double vu = v[0] * u[1];
  const double value = u[2] * (vw - wv) + v[2] * (wu - uw) + w[2] * (uv - vu);
  const double magnitude = (std::abs(vw) + std::abs(wv)) * std::abs(u[2]) +
                           (std::abs(wu) + std::abs(uw)) * std::abs(v[2]) +
                           (std::abs(uv) + std::abs(vu)) * std::abs(w[2]);
  if (const auto certain = certain_sign(value, magnitude, kError3)) return *certain;
  return exact_sign<12>({a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], d[0], d[1], d[2]});
}

int orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  if (const auto certain = certain_sign(left - right, std::abs(left) + std::abs(right), kError2)) {
    return *certain;
  }
  return exact_sign<6>({a[0], a[1], b[0], b[1], c[0], c[1]});
}

}  // namespace multitetra
