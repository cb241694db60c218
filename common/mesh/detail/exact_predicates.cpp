#include "common/mesh/detail/exact_predicates.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace multitetra {
namespace {

// Two's complement integers with a fixed number of 64-bit limbs. Overflow wraps around unchecked.
template <std::size_t limbs>
class FixedInteger {
 public:
  FixedInteger() = default;
  explicit FixedInteger(std::int64_t value) {
    limbs_.fill(value < 0 ? ~std::uint64_t{0} : 0);
    limbs_[0] = static_cast<std::uint64_t>(value);
  }

  [[nodiscard]] int sign() const {
    if (limbs_.back() >> 63 != 0) return -1;
    for (const std::uint64_t limb : limbs_) {
      if (limb != 0) return 1;
    }
    return 0;
  }

  // Returns the value times 2^bits; requires bits >= 0.
  [[nodiscard]] FixedInteger shifted(int bits) const {
    const auto whole = static_cast<std::size_t>(bits) / 64;
    const int rest = bits % 64;
    FixedInteger result;
    for (std::size_t i = whole; i < limbs; ++i) {
      result.limbs_[i] = limbs_[i - whole] << rest;
      if (rest != 0 && i > whole) result.limbs_[i] |= limbs_[i - whole - 1] >> (64 - rest);
    }
    return result;
  }

  friend FixedInteger operator+(const FixedInteger& a, const FixedInteger& b) {
    return added(a, b, 0, 0);
  }
  // Computes a + not b + 1.
  friend FixedInteger operator-(const FixedInteger& a, const FixedInteger& b) {
    return added(a, b, ~std::uint64_t{0}, 1);
  }
  friend FixedInteger operator*(const FixedInteger& a, const FixedInteger& b) {
    FixedInteger product;
    for (std::size_t i = 0; i < limbs; ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; i + j < limbs; ++j) {
        const Wide sum = Wide{a.limbs_[i]} * b.limbs_[j] + product.limbs_[i + j] + carry;
        product.limbs_[i + j] = static_cast<std::uint64_t>(sum);
        carry = static_cast<std::uint64_t>(sum >> 64);
      }
    }
    return product;
  }

 private:
  __extension__ using Wide = unsigned __int128;

  static FixedInteger added(const FixedInteger& a, const FixedInteger& b, std::uint64_t flips,
                            std::uint64_t carry) {
    FixedInteger sum;
    for (std::size_t i = 0; i < limbs; ++i) {
      const Wide both = Wide{a.limbs_[i]} + (b.limbs_[i] ^ flips) + carry;
      sum.limbs_[i] = static_cast<std::uint64_t>(both);
      carry = static_cast<std::uint64_t>(both >> 64);
    }
    return sum;
  }

  std::array<std::uint64_t, limbs> limbs_{};
};

// Error bounds of the determinants below in double, relative to the sums of the magnitudes of their
// terms (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust geometric
// predicates"). Valid unless a term underflows.
constexpr double kEpsilon = 0x1p-53;
constexpr double kError3 = (7 + 56 * kEpsilon) * kEpsilon;
constexpr double kError2 = (3 + 16 * kEpsilon) * kEpsilon;
constexpr double kMinMagnitude = 1e-250;

int sign(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// Returns the sign of a determinant in double, unless the error could change it.
std::optional<int> certain_sign(double determinant, double magnitude, double error) {
  if (magnitude == 0) return std::nullopt;  // Terms may have underflowed.
  if (magnitude > kMinMagnitude && std::abs(determinant) > error * magnitude) {
    return sign(determinant);
  }
  return std::nullopt;
}

// value = factor * 2^exponent with an odd factor below 2^53; 0 = 0 * 2^0.
struct OddFactor {
  std::int64_t factor = 0;
  int exponent = 0;
};
OddFactor odd_factor_of(double value) {
  if (value == 0) return {};
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa >> zeros, exponent - 53 + zeros};
}

// Coordinates are multiples of 2^lowest and less than 2^highest.
struct BinaryRange {
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();
};
BinaryRange range_of(std::span<const double> coordinates) {
  BinaryRange range;
  for (const double value : coordinates) {
    if (value == 0) continue;
    range.lowest = std::min(range.lowest, odd_factor_of(value).exponent);
    range.highest = std::max(range.highest, std::ilogb(value) + 1);
  }
  return range;
}

// The rows are differences to the last point.
template <typename Number>
Number determinant(const std::array<Number, 12>& p) {
  const auto d = [&](std::size_t point, std::size_t axis) -> Number {
    return p[3 * point + axis] - p[9 + axis];
  };
  const auto minor = [&](std::size_t i, std::size_t j) -> Number {
    return d(i, 0) * d(j, 1) - d(j, 0) * d(i, 1);
  };
  return d(0, 2) * minor(1, 2) + d(1, 2) * minor(2, 0) + d(2, 2) * minor(0, 1);
}

template <typename Number>
Number determinant(const std::array<Number, 6>& p) {
  const auto d = [&](std::size_t point, std::size_t axis) -> Number {
    return p[2 * point + axis] - p[4 + axis];
  };
  return d(0, 0) * d(1, 1) - d(1, 0) * d(0, 1);
}

// Computes the sign in integers: the coordinates times 2^-lowest.
template <typename Number, std::size_t count>
int sign_in(const std::array<double, count>& coordinates, int lowest) {
  std::array<Number, count> integers;
  for (std::size_t i = 0; i < count; ++i) {
    const OddFactor odd = odd_factor_of(coordinates[i]);
    if (odd.factor != 0) integers[i] = Number(odd.factor).shifted(odd.exponent - lowest);
  }
  return determinant(integers).sign();
}

template <std::size_t count>
int exact_sign(const std::array<double, count>& coordinates) {
  // A sum of six products of three differences has 3 bits more than three differences together. A
  // difference has 1 bit more than a coordinate. Another bit is the sign.
  constexpr int kFastBits = 82;
  static_assert(3 * (kFastBits + 1) + 3 + 1 <= 256);
  constexpr int kMaxBits = 1024 + 1074;
  static_assert(3 * (kMaxBits + 1) + 3 + 1 <= 64 * 99);
  const BinaryRange range = range_of(coordinates);
  if (range.highest < range.lowest) return 0;
  if (range.highest - range.lowest <= kFastBits) {
    return sign_in<FixedInteger<4>>(coordinates, range.lowest);
  }
  return sign_in<FixedInteger<99>>(coordinates, range.lowest);
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
