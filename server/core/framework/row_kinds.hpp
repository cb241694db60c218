// Rows of dividing points of one kind along x: their diamonds and children have the same offsets,
// whichever diagonal of a face or cube is the split edge.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/framework/diamond.hpp"

namespace multitetra {

// The points of one kind in a row along x: every second point, or none.
struct RowKind {
  bool exists = false;
  bool is_edge = false;
  bool odd_x = false;
  PointList<11> diamond;  // The point, its split edge and its link, in units of the spacing.
  PointList<8> children;  // In units of the children's spacing.
};

// Indexed by kind and by 2 * (z is odd) + (y is odd), in units of the spacing.
[[nodiscard]] constexpr std::array<std::array<RowKind, 4>, 3> make_row_kinds() {
  std::array<std::array<RowKind, 4>, 3> rows{};
  for (int kind = 0; kind < 3; ++kind) {
    for (int row = 0; row < 4; ++row) {
      const int odd_x = kind + 1 - (row & 1) - (row >> 1);
      if (odd_x != 0 && odd_x != 1) continue;
      RowKind& shape = rows[static_cast<std::size_t>(kind)][static_cast<std::size_t>(row)];
      shape.exists = true;
      shape.is_edge = kind == 0;
      shape.odd_x = odd_x == 1;
      const GridPoint unit_point = {4 + odd_x, 4 + (row & 1), 4 + (row >> 1)};
      const Diamond& diamond = diamond_of(unit_point);
      shape.diamond.push_back({});
      for (std::size_t i = 0; i < diamond.corners; ++i) {
        shape.diamond.push_back(diamond.offsets[i]);
      }
      // Doubled, so that the children of an edge are grid points.
      const DividingPoint point(2 * unit_point);
      const PointList<8> children = point.children(Grid(5));
      for (const GridPoint child : children) {
        const GridPoint offset = child - point.at();
        shape.children.push_back(point.kind() == PointKind::kEdge
                                     ? offset
                                     : GridPoint{offset.x / 2, offset.y / 2, offset.z / 2});
      }
    }
  }
  return rows;
}
inline constexpr std::array<std::array<RowKind, 4>, 3> kRowKinds = make_row_kinds();

// Returns the points of `kind` in the row (y, z), in units of their spacing.
[[nodiscard]] constexpr const RowKind& row_kind(PointKind kind, std::int32_t y, std::int32_t z) {
  return kRowKinds[static_cast<std::size_t>(kind)]
                  [static_cast<std::size_t>((y & 1) | (z & 1) << 1)];
}

}  // namespace multitetra
