// The fraction of a cell of eight samples inside each label's surface. It is the mean over the
// cell's six tetrahedra of the finest level (see server/core/framework/tetrahedron.hpp) of the part
// where the label's linear field is positive, with crossings on the lattice of vertices.
//
// Bits number the corners: 1 along x, 2 along y, 4 along z. All six tetrahedra share the diagonal
// from the corner with even coordinates to the opposite one. A margin of the grid can only exchange
// these two, so sample indices serve as coordinates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "common/mesh/lattice.hpp"

namespace multitetra {

struct LabelCell {
  std::array<std::int32_t, 8> labels{};
  std::array<int, 8> magnitudes{};  // Greater than 0.
  unsigned even_corner = 0;
};

// Returns the fraction of a tetrahedron where a linear field is positive, from its nonzero values
// at the corners. Crossings are rounded from the earlier corner, which must be the lesser one as
// for lattice_vertex().
[[nodiscard]] inline double positive_part(const std::array<int, 4>& values) {
  std::array<std::size_t, 4> inside{};
  std::array<std::size_t, 4> outside{};
  std::size_t insides = 0;
  std::size_t outsides = 0;
  for (std::size_t i = 0; i < 4; ++i) (values[i] > 0 ? inside[insides++] : outside[outsides++]) = i;
  // The part of the edge from corner a to b on the side of a.
  const auto part = [&](std::size_t a, std::size_t b) {
    constexpr double kSteps = 1 << kDefaultLatticeResolution;
    const double t = values[std::min(a, b)] /
                     static_cast<double>(values[std::min(a, b)] - values[std::max(a, b)]);
    const double q = std::clamp(std::floor(kSteps * t + 0.5), 1.0, kSteps - 1) / kSteps;
    return a < b ? q : 1 - q;
  };
  const auto corner = [&](std::size_t a, const std::array<std::size_t, 4>& b) {
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
  constexpr std::array<std::array<unsigned, 4>, 6> kTetrahedra = {
      {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};
  // Corners from the lesser to the greater one, with x as the first coordinate.
  constexpr std::array<unsigned, 8> kOrder = {0, 4, 2, 6, 1, 5, 3, 7};
  double sum = 0;
  for (const auto& tetrahedron : kTetrahedra) {
    std::array<int, 4> values{};
    std::size_t count = 0;
    for (const unsigned at : kOrder) {
      const auto begin = tetrahedron.begin();
      if (std::find(begin, tetrahedron.end(), at ^ cell.even_corner) == tetrahedron.end()) continue;
      values[count++] = cell.labels[at] == label ? cell.magnitudes[at] : -cell.magnitudes[at];
    }
    sum += positive_part(values);
  }
  return sum / static_cast<double>(kTetrahedra.size());
}

}  // namespace multitetra
