#include "common/codec/detail/cell_cases.hpp"

namespace multitetra::shell {

namespace {

// The corners of the six paths from 0 to 7, and whether they span a negative volume.
struct CornerPath {
  uint8_t corners[4];
  bool is_negative;
};
constexpr CornerPath kCornerPaths[6] = {{{0, 1, 3, 7}, false}, {{0, 1, 5, 7}, true},
                                        {{0, 2, 3, 7}, true},  {{0, 2, 6, 7}, false},
                                        {{0, 4, 5, 7}, false}, {{0, 4, 6, 7}, true}};

uint8_t edge_between(CellCases& cases, int& known, uint8_t a, uint8_t b) {
  const uint8_t low = a < b ? a : b;
  const uint8_t high = a < b ? b : a;
  for (int i = 0; i < known; ++i) {
    if (cases.edge_ends[i][0] == low && cases.edge_ends[i][1] == high) {
      return static_cast<uint8_t>(i);
    }
  }
  cases.edge_ends[known][0] = low;
  cases.edge_ends[known][1] = high;
  return static_cast<uint8_t>(known++);
}

void add_polygon(CellCases& cases, int& known_edges, const CornerPath& path, bool is_mirrored,
                 unsigned signs, CellCase& out) {
  // Orders positive corners first and tracks whether that is an odd permutation.
  uint8_t order[4] = {};
  int positives = 0;
  int last = 4;
  for (uint8_t i = 0; i < 4; ++i) {
    const bool is_positive = (signs >> path.corners[i] & 1U) != 0;
    order[is_positive ? positives++ : --last] = i;
  }
  if (positives == 0 || positives == 4) return;
  bool turned = path.is_negative != is_mirrored;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) turned = turned != (order[i] > order[j]);
  }
  CellPolygon& polygon = out.polygon[out.polygons++];
  for (const uint8_t corner : path.corners) {
    polygon.tetrahedron = static_cast<uint8_t>(polygon.tetrahedron | 1U << corner);
  }
  const auto edge = [&](int i, int j) {
    return edge_between(cases, known_edges, path.corners[order[i]], path.corners[order[j]]);
  };
  const auto swap = [&polygon](int i, int j) {
    const uint8_t kept = polygon.edges[i];
    polygon.edges[i] = polygon.edges[j];
    polygon.edges[j] = kept;
  };
  if (positives == 2) {
    polygon.corners = 4;
    polygon.edges[0] = edge(0, 2);
    polygon.edges[1] = edge(0, 3);
    polygon.edges[2] = edge(1, 3);
    polygon.edges[3] = edge(1, 2);
    if (turned) swap(1, 3);
  } else {
    const int one = positives == 1 ? 0 : 3;
    polygon.corners = 3;
    polygon.edges[0] = edge(one, one == 0 ? 1 : 0);
    polygon.edges[1] = edge(one, one == 0 ? 2 : 1);
    polygon.edges[2] = edge(one, one == 0 ? 3 : 2);
    if (turned) swap(1, 2);
  }
  out.triangles = static_cast<uint8_t>(out.triangles + polygon.corners - 2);
}

CellCases make_cell_cases() {
  CellCases cases{};
  int known_edges = 0;
  for (int mirrored = 0; mirrored < 2; ++mirrored) {
    for (unsigned signs = 0; signs < 256; ++signs) {
      for (const CornerPath& path : kCornerPaths) {
        add_polygon(cases, known_edges, path, mirrored != 0, signs, cases.of[mirrored][signs]);
      }
    }
  }
  return cases;
}

}  // namespace

const CellCases& cell_cases() {
  static const CellCases cases = make_cell_cases();
  return cases;
}

}  // namespace multitetra::shell
