// The own error of a dividing point: the error of fusing it, without that of its descendants (Zhou,
// Chen and Kaufman 1997, section 4).
//
// Fusing a point replaces its value m by v = (a + b) / 2, the mean of the ends of its split edge.
// On the segment from the point to a corner X of its diamond, the crossing moves by |t(m) - t(v)|
// |pX|, where t(y) = (c - y) / (x - y) if x and y lie on different sides of the isovalue c, else 0:
// a crossing appears or vanishes at the point.
//
// A point is *positive* if its value is greater than c. If a and b have the same sign and m has the
// other, fusing is a *flip*. If a, b and m have the same sign, no sign changes. If a and b differ,
// the positive and the negative part of the link are cones over the positive and the negative end,
// whatever the sign of m. So only flips can change the topology, and a flip does unless the signs
// on the ring around the split edge change exactly twice. Such a flip is *critical*.
#pragma once

#include <algorithm>
#include <cstddef>

#include "server/core/framework/diamond_values.hpp"
#include "server/core/framework/dividing_point.hpp"
#include "server/core/framework/field.hpp"
#include "server/core/framework/grid_step_lengths.hpp"

namespace multitetra {

struct OwnError {
  // The paper's error without its treatment of flips. World units.
  double displacement = 0;
  // The displacement; but if m and v lie on different sides of c, the surface passes through the
  // point, and this is the largest t(m)|pX| plus the largest t(v)|pX|. World units.
  double certified = 0;
  bool flip = false;
  bool critical = false;  // Implies flip.
};

// Returns the largest |t(m) - t(v)| L over the corners beyond c. Requires m and v on one side.
[[nodiscard]] inline double largest_displacement(const DiamondValues<double>& d, double v,
                                                 double c) {
  using Vector = Lanes<double>::Vector;
  const Vector m_lanes = all(d.center);
  const Vector v_lanes = all(v);
  const Vector isovalue = all(c);
  const Vector one = all(1.0);
  Vector largest{};
  for (std::size_t i = 0; i < d.vectors; ++i) {
    const Vector x = d.value.vectors[i];
    const auto is_crossed = d.center > c ? x <= isovalue : x > isovalue;
    const Vector t_m = (isovalue - m_lanes) / (is_crossed ? x - m_lanes : one);
    const Vector t_v = (isovalue - v_lanes) / (is_crossed ? x - v_lanes : one);
    const Vector moved = (t_m < t_v ? t_v - t_m : t_m - t_v) * d.length->vectors[i];
    largest = larger(largest, is_crossed ? moved : Vector{});
  }
  return largest_of<double>(largest);
}

// The largest t(m) L and the largest t(v) L for m and v on different sides of c: each corner has a
// crossing with one of the two.
struct Crossings {
  double from_m = 0;
  double from_v = 0;
};
[[nodiscard]] inline Crossings largest_crossings(const DiamondValues<double>& d, double v,
                                                 double c) {
  using Vector = Lanes<double>::Vector;
  const Vector m_lanes = all(d.center);
  const Vector v_lanes = all(v);
  const Vector isovalue = all(c);
  Vector from_m{};
  Vector from_v{};
  for (std::size_t i = 0; i < d.vectors; ++i) {
    const Vector x = d.value.vectors[i];
    const auto with_m = d.center > c ? x <= isovalue : x > isovalue;
    const Vector y = with_m ? m_lanes : v_lanes;
    const Vector moved = (isovalue - y) / (x - y) * d.length->vectors[i];
    from_m = larger(from_m, with_m ? moved : Vector{});
    from_v = larger(from_v, with_m ? Vector{} : moved);
  }
  return {largest_of<double>(from_m), largest_of<double>(from_v)};
}

// Returns the error for the isovalue c, exact in double. A diamond with void corners is a critical
// flip, so that the surface ends at the last samples. Requires values on both sides of c.
[[nodiscard]] inline OwnError own_error_of_mixed(const DiamondValues<double>& d, double c) {
  auto sum = all(d.center);
  for (std::size_t i = 0; i < d.vectors; ++i) sum += d.value.vectors[i];
  const bool any_void = sum[0] != sum[0] || sum[1] != sum[1];
  if (any_void) {
    return {.displacement = 0, .certified = 0, .flip = true, .critical = true};
  }
  const double m = d.center;
  const double v = 0.5 * (d.value[0] + d.value[1]);
  OwnError result;
  if ((m > c) == (v > c)) {
    result.displacement = largest_displacement(d, v, c);
    result.certified = result.displacement;
  } else {
    const auto [from_m, from_v] = largest_crossings(d, v, c);
    result.displacement = std::max(from_m, from_v);
    result.certified = from_m + from_v;
  }

  const bool m_is_positive = m > c;
  const bool a_is_positive = d.value[0] > c;
  result.flip = a_is_positive == (d.value[1] > c) && m_is_positive != a_is_positive;
  if (result.flip) {
    int changes = 0;
    bool before = d.value[d.corners - 1] > c;
    for (std::size_t i = 2; i < d.corners; ++i) {
      const bool is_positive = d.value[i] > c;
      changes += is_positive != before ? 1 : 0;
      before = is_positive;
    }
    result.critical = d.ring_is_open || changes != 2;
  }
  return result;
}

// Returns the own error for any values; 0 unless they lie on both sides of c.
[[nodiscard]] inline OwnError own_error(const DiamondValues<double>& d, double c) {
  const ValueRange<double> range = range_of(d);
  return range.high > c && range.low <= c ? own_error_of_mixed(d, c) : OwnError{};
}

// Returns the own error of a point of a field.
template <typename Sample>
[[nodiscard]] OwnError own_error(const SampledField<Sample>& field, const Grid& grid,
                                 const GridStepLengths& lengths, const DividingPoint& point,
                                 double c) {
  Lanes<double> length{};
  DiamondValues<double> d;
  d.center = static_cast<double>(field.at(point.at()));
  d.corners = 0;
  d.vectors = Lanes<double>::kVectors;
  for (auto& lanes : d.value.vectors) lanes = all(d.center);
  const auto add = [&](GridPoint x) {
    length.set(d.corners, lengths(x - point.at(), point.spacing()));
    d.value.set(d.corners++, static_cast<double>(field.at(x)));
  };
  const auto [a, b] = point.split_edge();
  add(a);
  add(b);
  const PointList<8> ring = point.ring();
  for (const GridPoint x : ring) {
    if (grid.contains(x)) add(x);
  }
  d.ring_is_open = d.corners != 2 + ring.size();
  d.length = &length;
  return own_error(d, c);
}

}  // namespace multitetra
