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

#include <algorithm>
#include <array>
#include <cmath>

#include "common/affine.hpp"
#include "server/core/dividing_point.hpp"
#include "server/core/field.hpp"

namespace multitetra {

struct OwnError {
  double displacement = 0;  // The paper's error without its treatment of flips, in world units.
  double certified =
      0;  // As above, but where m and v lie on different sides of c the surface passes through the
          // point: the largest t(m)|pX| plus the largest t(v)|pX|. In world units.
  bool flip = false;
  bool critical = false;  // Implies flip.
};

// Lengths of the 26 steps to the neighbours of a point, in world units, for a step of one grid
// step.
class StepLengths {
 public:
  explicit StepLengths(const Vec3& spacing) {
    for (int code = 0; code < 27; ++code) {
      const std::array<int, 3> step = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double along = step[axis] * spacing[axis];
        square += along * along;
      }
      lengths_[static_cast<std::size_t>(code)] = std::sqrt(square);
    }
  }
  // The length of `offset`, whose coordinates are each 0 or +-spacing.
  [[nodiscard]] double operator()(GridPoint offset, std::int32_t spacing) const {
    const auto sign = [](std::int32_t v) { return v > 0 ? 2 : v < 0 ? 0 : 1; };
    return spacing * lengths_[static_cast<std::size_t>(sign(offset.x) + 3 * sign(offset.y) +
                                                       9 * sign(offset.z))];
  }

 private:
  std::array<double, 27> lengths_{};
};

// Exact for the isovalue c, in double precision. A diamond with void corners is a critical flip
// when its other values are not all on one side, so that the surface ends exactly at the last
// samples; otherwise its error is 0.
template <typename Sample>
[[nodiscard]] OwnError own_error(const SampledField<Sample>& field, const Grid& grid,
                                 const StepLengths& lengths, const DividingPoint& point, double c) {
  struct Corner {
    double value;
    double length;
  };
  std::array<Corner, 10> corners;
  std::size_t count = 0;
  bool any_void = false;
  bool any_positive = false;
  bool any_negative = false;
  const auto note = [&](float value) {
    if (is_void(value)) {
      any_void = true;
    } else {
      (value > c ? any_positive : any_negative) = true;
    }
    return static_cast<double>(value);
  };
  const auto add = [&](GridPoint x) {
    corners[count++] = {note(field.at(x)), lengths(x - point.at(), point.spacing())};
  };

  const double m = note(field.at(point.at()));
  const auto [a, b] = point.split_edge();
  add(a);
  add(b);
  const PointList<8> ring = point.ring();
  for (const GridPoint x : ring) {
    if (grid.contains(x)) add(x);
  }
  if (!(any_positive && any_negative)) return {};
  if (any_void) return {.flip = true, .critical = true};

  const double v = 0.5 * (corners[0].value + corners[1].value);
  const auto positive = [c](double value) { return value > c; };
  const auto crossing = [&](double y, double x) {
    return positive(x) != positive(y) ? (c - y) / (x - y) : 0.0;
  };
  OwnError result;
  double from_m = 0;
  double from_v = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t_m = crossing(m, corners[i].value);
    const double t_v = crossing(v, corners[i].value);
    result.displacement = std::max(result.displacement, std::abs(t_m - t_v) * corners[i].length);
    from_m = std::max(from_m, t_m * corners[i].length);
    from_v = std::max(from_v, t_v * corners[i].length);
  }
  result.certified = positive(m) != positive(v) ? from_m + from_v : result.displacement;

  result.flip = positive(corners[0].value) == positive(corners[1].value) &&
                positive(m) != positive(corners[0].value);
  if (result.flip) {
    const bool ring_is_open = count != 2 + ring.size();
    int changes = 0;
    for (std::size_t i = 2; i < count; ++i) {
      const std::size_t next = i + 1 < count ? i + 1 : 2;
      changes += positive(corners[i].value) != positive(corners[next].value) ? 1 : 0;
    }
    result.critical = ring_is_open || changes != 2;
  }
  return result;
}

}  // namespace multitetra
