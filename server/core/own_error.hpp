// The error that fusing one dividing point makes, before that of its descendants is added (Zhou,
// Chen and Kaufman 1997, section 4).
//
// Fusing a point replaces its value m by v = (a + b) / 2, the mean of the ends of its split edge.
// On every segment from the point to a corner X of its diamond the surface's crossing moves by
// |t(m) - t(v)| |pX|, where t(y) = (c - y) / (x - y) if x and y are on different sides of the
// isovalue c, else 0: a crossing that appears or vanishes does so at the point.
//
// The sign of a point is "positive" when its value is greater than c. If a and b agree and m does
// not, fusing is a *flip*. If a, b and m agree no sign changes. If a and b differ, the positive
// part of the link is a cone over the positive end, the negative part one over the negative end,
// and nothing changes whatever the sign of m. So only flips can change the topology, and a flip
// does exactly when the signs on the ring around the split edge do not change exactly twice: it is
// then *critical*.
#pragma once

#include "server/core/diamond_values.hpp"
#include "server/core/dividing_point.hpp"
#include "server/core/field.hpp"
#include "server/core/step_lengths.hpp"

namespace multitetra {

struct OwnError {
  double displacement = 0;  // The paper's error without its treatment of flips, in world units.
  double certified =
      0;  // As above, but where m and v lie on different sides of c the surface passes through the
          // point: the largest t(m)|pX| plus the largest t(v)|pX|. In world units.
  bool flip = false;
  bool critical = false;  // Implies flip.
};

// Exact for the isovalue c, in double precision. A diamond with void corners is a critical flip
// when its other values are not all on one side, so that the surface ends exactly at the last
// samples; otherwise its error is 0.
[[nodiscard]] inline OwnError own_error(const DiamondValues<double>& d, double c) {
  const ValueRange<double> range = range_of(d);
  if (!(range.high > c) || range.low > c) return {};
  if (range.any_void) return {.displacement = 0, .certified = 0, .flip = true, .critical = true};

  using Vector = Lanes<double>::Vector;
  const double m = d.centre;
  const double v = 0.5 * (d.value[0] + d.value[1]);
  const bool m_is_positive = m > c;
  const bool v_is_positive = v > c;
  const Vector isovalue = all(c);
  // Lanes behind the last corner hold m and the length 0: they add nothing.
  const auto crossing = [&](double y, bool y_is_positive, Vector x) {
    const auto is_crossed = y_is_positive ? x <= isovalue : x > isovalue;
    const Vector t = all(c - y) / (is_crossed ? x - all(y) : all(1.0));
    return is_crossed ? t : Vector{};
  };
  Vector displacement{};
  Vector from_m{};
  Vector from_v{};
  for (std::size_t i = 0; i < d.vectors; ++i) {
    const Vector x = d.value.vectors[i];
    const Vector length = d.length->vectors[i];
    const Vector t_m = crossing(m, m_is_positive, x);
    const Vector t_v = crossing(v, v_is_positive, x);
    const Vector moved = t_m - t_v;
    displacement = larger(displacement, (moved < Vector{} ? -moved : moved) * length);
    from_m = larger(from_m, t_m * length);
    from_v = larger(from_v, t_v * length);
  }
  OwnError result;
  result.displacement = largest_of<double>(displacement);
  result.certified = m_is_positive != v_is_positive
                         ? largest_of<double>(from_m) + largest_of<double>(from_v)
                         : result.displacement;

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

// The same, with the values taken from a field.
template <typename Sample>
[[nodiscard]] OwnError own_error(const SampledField<Sample>& field, const Grid& grid,
                                 const StepLengths& lengths, const DividingPoint& point, double c) {
  Lanes<double> length{};
  DiamondValues<double> d;
  d.centre = static_cast<double>(field.at(point.at()));
  d.corners = 0;
  d.vectors = Lanes<double>::kVectors;
  for (auto& lanes : d.value.vectors) lanes = all(d.centre);
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
