// The fraction of a cell of eight samples inside each label's surface. It is the mean over the
// cell's six tetrahedra of the finest level (see server/core/framework/tetrahedron.hpp) of the part
// where the label's linear field is positive.
//
// Bits number the corners: 1 along x, 2 along y, 4 along z. All six tetrahedra share the diagonal
// from the corner with even coordinates to the opposite one. A margin of the grid can only exchange
// these two, so sample indices serve as coordinates.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace multitetra {

struct LabelCell {
  std::array<std::int32_t, 8> labels{};
  std::array<int, 8> magnitudes{};  // Greater than 0.
  unsigned even_corner = 0;
};

// Returns the fraction of a tetrahedron where a linear field is positive, from its nonzero values
// at the corners.
[[nodiscard]] inline double positive_part(const std::array<int, 4>& values) {
  std::array<double, 4> inside{};
  std::array<double, 4> outside{};
  std::size_t insides = 0;
  std::size_t outsides = 0;
  for (const int value : values) {
    if (value > 0) {
      inside[insides++] = value;
    } else {
      outside[outsides++] = -value;
    }
  }
  // The part of the edge from a to b on the side of a.
  const auto part = [](double a, double b) { return a / (a + b); };
  const auto corner = [&](double a, const std::array<double, 4>& b) {
    return part(a, b[0]) * part(a, b[1]) * part(a, b[2]);
  };
  switch (insides) {
    case 0:
      return 0;
    case 1:
      return corner(inside[0], outside);
    case 3:
      return 1 - corner(outside[0], inside);
    case 4:
      return 1;
    default:
      break;
  }
  // A wedge, divided into three tetrahedra.
  const double t00 = part(inside[0], outside[0]);
  const double t01 = part(inside[0], outside[1]);
  const double t10 = part(inside[1], outside[0]);
  const double t11 = part(inside[1], outside[1]);
  return t10 * t11 + t00 * t01 * (1 - t11) + t00 * t11 * (1 - t10);
}

// Returns the fraction of the cell inside the surface of `label`.
[[nodiscard]] inline double part_of_cell(const LabelCell& cell, std::int32_t label) {
  constexpr std::array<std::array<unsigned, 2>, 6> kPaths = {
      {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}}};
  const auto value = [&](unsigned corner) {
    const std::size_t at = cell.even_corner ^ corner;
    return cell.labels[at] == label ? cell.magnitudes[at] : -cell.magnitudes[at];
  };
  double sum = 0;
  for (const auto& [second, third] : kPaths) {
    sum += positive_part({value(0), value(second), value(third), value(7)});
  }
  return sum / static_cast<double>(kPaths.size());
}

}  // namespace multitetra
