// The polygons in which the surface cuts the six tetrahedra of a cell.
//
// Seen from its corner with even coordinates every cell looks the same: its tetrahedra are the six
// shortest paths from corner 0 to corner 7, where corners have numbers x + 2 y + 4 z in that view.
// A cell whose even corner is elsewhere is mirrored along those axes, which reverses polygons if
// their number is odd. The polygon of a tetrahedron is core's MarchingCase.
#pragma once

#include <stdint.h>

namespace multitetra::shell {

inline constexpr int kCellEdges = 19;

struct CellPolygon {
  uint8_t corners = 0;      // 3 or 4.
  uint8_t tetrahedron = 0;  // One bit per corner.
  uint8_t edges[4] = {};
};
struct CellCase {
  uint8_t polygons = 0;
  uint8_t triangles = 0;
  CellPolygon polygon[6];
};

struct CellCases {
  uint8_t edge_ends[kCellEdges][2];  // Cell corners, the lower number first.
  CellCase of[2][256];               // [is mirrored][bits of positive corners]
};

// Computed once.
[[nodiscard]] const CellCases& cell_cases();

}  // namespace multitetra::shell
