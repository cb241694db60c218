// The field's values in a diamond, in vector registers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "server/core/framework/diamond.hpp"
#include "server/core/framework/grid_step_lengths.hpp"

namespace multitetra {

template <typename Vector>
[[nodiscard]] inline Vector larger(Vector a, Vector b) {
  return a > b ? a : b;
}

template <typename Real>
struct VectorOf;
template <>
struct VectorOf<float> {
  using Type = float __attribute__((vector_size(16)));
};
template <>
struct VectorOf<double> {
  using Type = double __attribute__((vector_size(16)));
};

// Vectors of up to twelve numbers. Comparisons and selections give the same bits on every machine.
// Real is float if arithmetic on the values is exact in it (16-bit integers), else double.
template <typename Real>
struct Lanes {
  static constexpr std::size_t kWidth = 16 / sizeof(Real);
  static constexpr std::size_t kVectors = 12 / kWidth;
  using Vector = typename VectorOf<Real>::Type;

  std::array<Vector, kVectors> vectors;

  [[nodiscard]] Real operator[](std::size_t i) const { return vectors[i / kWidth][i % kWidth]; }
  void set(std::size_t i, Real value) { vectors[i / kWidth][i % kWidth] = value; }
};

template <typename Real>
[[nodiscard]] inline typename Lanes<Real>::Vector all(Real value) {
  return typename Lanes<Real>::Vector{} + value;
}
template <typename Real, typename Vector>
[[nodiscard]] inline Real largest_of(Vector v) {
  if constexpr (Lanes<Real>::kWidth == 4) {
    v = larger(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
    v = larger(v, __builtin_shufflevector(v, v, 1, 0, 3, 2));
  } else {
    v = larger(v, __builtin_shufflevector(v, v, 1, 0));
  }
  return v[0];
}
template <typename Real, typename Vector>
[[nodiscard]] inline Real least_of(Vector v) {
  return -largest_of<Real>(-v);
}

template <typename Real>
struct DiamondValues {
  Real center;
  std::size_t corners;  // At most 10.
  // The number of vectors in use; lanes after the last corner repeat `center`.
  std::size_t vectors;
  bool ring_is_open;  // Set if corners beyond the grid's border were omitted.
  // The corners' values, ends of the split edge first.
  Lanes<Real> value;
  const Lanes<Real>* length;     // Distances from the point to the corners, in world units.
  Lanes<Real> length_at_border;  // The target of `length` if corners were omitted.
};

// The range of a diamond's values; the same for all bins.
template <typename Real>
struct ValueRange {
  // The least value that is not void, as `high` is the largest.
  Real low;
  Real high;
  bool any_void;
  [[nodiscard]] bool is_mixed() const { return low < high; }
};

template <typename Real>
[[nodiscard]] ValueRange<Real> range_of(const DiamondValues<Real>& d) {
  constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
  auto low = all(kInfinity);
  auto high = all(-kInfinity);
  bool any_void = false;
  const auto include = [&](auto x) {  // Comparisons with NaN are false, so it changes neither end.
    low = x < low ? x : low;
    high = x > high ? x : high;
  };
  include(all(d.center));
  auto sum = all(d.center);
  for (std::size_t i = 0; i < d.vectors; ++i) {
    include(d.value.vectors[i]);
    sum += d.value.vectors[i];
  }
  for (std::size_t i = 0; i < Lanes<Real>::kWidth; ++i) any_void |= sum[i] != sum[i];
  return {.low = least_of<Real>(low), .high = largest_of<Real>(high), .any_void = any_void};
}

// Distances to the corners in world units, by index of the shape, for points of spacing 2^exponent.
template <typename Real>
using DiamondLengths = std::array<Lanes<Real>, 64>;

template <typename Real>
[[nodiscard]] DiamondLengths<Real> diamond_lengths(const GridStepLengths& lengths, int exponent) {
  DiamondLengths<Real> result{};
  for (std::size_t shape = 0; shape < kDiamonds.size(); ++shape) {
    for (std::size_t i = 0; i < kDiamonds[shape].corners; ++i) {
      const GridPoint offset = kDiamonds[shape].offsets[i];
      result[shape].set(i, static_cast<Real>((1 << exponent) * lengths(offset, 1)));
    }
  }
  return result;
}

// Fills `d` for a point on the grid's border, omitting corners beyond it. `unit_point` and `last`,
// the grid's largest coordinate, are in units of the spacing; `value(i)` is that of corner i.
template <typename Real, typename Value>
void load_at_border(GridPoint unit_point, std::int32_t last, Real center,
                    const DiamondLengths<Real>& lengths, const Value& value,
                    DiamondValues<Real>& d) {
  const std::size_t index = diamond_index(unit_point);
  const Diamond& shape = kDiamonds[index];
  d.center = center;
  d.corners = 0;
  d.vectors = Lanes<Real>::kVectors;
  for (auto& lanes : d.value.vectors) lanes = all(center);
  d.length_at_border = {};
  d.length = &d.length_at_border;
  for (std::size_t i = 0; i < shape.corners; ++i) {
    const GridPoint corner = unit_point + shape.offsets[i];
    if (std::min({corner.x, corner.y, corner.z}) < 0 ||
        std::max({corner.x, corner.y, corner.z}) > last) {
      continue;
    }
    d.length_at_border.set(d.corners, lengths[index][i]);
    d.value.set(d.corners++, value(i));
  }
  d.ring_is_open = d.corners != shape.corners;
}

}  // namespace multitetra
