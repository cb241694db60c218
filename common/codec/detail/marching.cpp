#include "common/codec/detail/marching.hpp"

namespace multitetra::shell {

namespace {

int64_t squared_distance(const ShellVertex& a, const ShellVertex& b) {
  const auto square = [](int32_t d) { return int64_t{d} * d; };
  return square(a.x - b.x) + square(a.y - b.y) + square(a.z - b.z);
}

bool is_less(const ShellVertex& a, const ShellVertex& b) {
  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

// Returns a cell's corner bits, mirrored along x.
uint32_t mirrored_along_x(uint32_t corners) {
  return (corners & 0x55U) << 1 | (corners & 0xaaU) >> 1;
}

// The start of a cell's edge, relative to the cell's lowest corner, and its direction.
struct EdgeOfCell {
  int x;
  int y;
  int z;
  int direction;
};
EdgeOfCell edge_of_cell(const CellCases& cases, int edge, unsigned even_corner) {
  const unsigned a = cases.edge_ends[edge][0] ^ even_corner;
  const unsigned b = cases.edge_ends[edge][1] ^ even_corner;
  const auto along = [](unsigned corner, unsigned axis) {
    return static_cast<int>(corner >> axis & 1U);
  };
  const int dx = along(b, 0) - along(a, 0);
  const int dy = along(b, 1) - along(a, 1);
  const int dz = along(b, 2) - along(a, 2);
  const bool from_a = dz != 0 ? dz > 0 : dy != 0 ? dy > 0 : dx > 0;
  const unsigned from = from_a ? a : b;
  const int sign = from_a ? 1 : -1;
  int direction = 0;
  for (int d = 0; d < kEdgeDirections; ++d) {
    const EdgeDirection& one = kEdgeDirection[d];
    if (one.x == sign * dx && one.y == sign * dy && one.z == sign * dz) direction = d;
  }
  return {along(from, 0), along(from, 1), along(from, 2), direction};
}

struct CellEdgeTable {
  EdgeOfCell of[8][kCellEdges];  // Indexed by the corner with even coordinates.
};
const CellEdgeTable& cell_edge_table() {
  static const CellEdgeTable table = [] {
    CellEdgeTable made{};
    for (unsigned corner = 0; corner < 8; ++corner) {
      for (int edge = 0; edge < kCellEdges; ++edge) {
        made.of[corner][edge] = edge_of_cell(cell_cases(), edge, corner);
      }
    }
    return made;
  }();
  return table;
}

}  // namespace

bool is_cut_along_first(const ShellVertex& p, const ShellVertex& q, const ShellVertex& r,
                        const ShellVertex& s) {
  const int64_t pr = squared_distance(p, r);
  const int64_t qs = squared_distance(q, s);
  if (pr != qs) return pr < qs;
  return is_less(is_less(r, p) ? r : p, is_less(s, q) ? s : q);
}

void Marching::begin(const BitField& signs, const BitField* present, const ShellHeader& header) {
  signs_ = &signs;
  present_ = present;
  cases_ = &cell_cases();
  steps_ = header.steps();
  for (int axis = 0; axis < 3; ++axis) {
    origin_[axis] = header.origin[axis];
    lattice_origin_[axis] = header.origin[axis] * steps_;
  }
  max_vertices_ = header.vertices;
  max_triangles_ = header.triangles;
  vertex_count_ = 0;
  triangle_count_ = 0;
  not_last_ = samples_from_to(0, signs.size(0) - 1);
}

// Four rows of samples and the cells between them, seen from the corner with even coordinates.
class Marching::RowOfCells {
 public:
  RowOfCells(const BitField& field, int y, int z, unsigned odd_y, unsigned odd_z)
      : rows_{&row(field, y, z, odd_y, odd_z), &row(field, y, z, odd_y ^ 1U, odd_z),
              &row(field, y, z, odd_y, odd_z ^ 1U), &row(field, y, z, odd_y ^ 1U, odd_z ^ 1U)} {}

  // Returns the cells with corners of both signs.
  [[nodiscard]] RowBits mixed() const {
    const RowBits some = *rows_[0] | *rows_[1] | *rows_[2] | *rows_[3];
    const RowBits all = *rows_[0] & *rows_[1] & *rows_[2] & *rows_[3];
    return (some | of_next(some)) & ~(all & of_next(all));
  }
  // Returns the bits of a cell's corners. `is_odd`: its lower x is odd.
  [[nodiscard]] uint32_t corners(int x, bool is_odd) const {
    const uint32_t bits =
        (bits_from(*rows_[0], x + 1) & 3U) | (bits_from(*rows_[1], x + 1) & 3U) << 2 |
        (bits_from(*rows_[2], x + 1) & 3U) << 4 | (bits_from(*rows_[3], x + 1) & 3U) << 6;
    return is_odd ? mirrored_along_x(bits) : bits;
  }

 private:
  static const RowBits& row(const BitField& field, int y, int z, unsigned up_y, unsigned up_z) {
    return field.row(y + static_cast<int>(up_y), z + static_cast<int>(up_z));
  }
  const RowBits* rows_[4];
};

template <bool kHasVoid>
bool Marching::add_row_of_cells(int y, int z, ShellVertex* vertices, ShellTriangle* triangles) {
  const unsigned odd_y = static_cast<unsigned>(y + origin_[1]) & 1U;
  const unsigned odd_z = static_cast<unsigned>(z + origin_[2]) & 1U;
  const RowOfCells cells(*signs_, y, z, odd_y, odd_z);
  const RowBits mixed = cells.mixed() & not_last_;
  if (!mixed.any()) return true;
  const RowOfCells present(kHasVoid ? *present_ : *signs_, y, z, odd_y, odd_z);

  // Where the vertex indices of a cell's edges are stored, for cells with even and odd x.
  const EdgeOfCell* const edges[2] = {cell_edge_table().of[odd_y << 1 | odd_z << 2],
                                      cell_edge_table().of[1U | odd_y << 1 | odd_z << 2]};
  uint32_t* numbers[2][kCellEdges];
  for (int odd_x = 0; odd_x < 2; ++odd_x) {
    for (int edge = 0; edge < kCellEdges; ++edge) {
      const EdgeOfCell& one = edges[odd_x][edge];
      numbers[odd_x][edge] = numbers_[(z + one.z) & 1][y + one.y][one.direction] + one.x;
    }
  }

  bool has_room = true;
  for_each_sample(mixed, [&](int x) {
    const int odd_x = (x + origin_[0]) & 1;
    const CellCase& cell =
        cases_->of[static_cast<unsigned>(odd_x) ^ odd_y ^ odd_z][cells.corners(x, odd_x != 0)];
    if (!kHasVoid && cell.triangles > max_triangles_ - triangle_count_) {
      has_room = false;
      return;
    }
    const unsigned present_corners = kHasVoid ? present.corners(x, odd_x != 0) : 0xffU;
    const auto vertex = [&](uint8_t edge) {
      uint32_t& number = numbers[odd_x][edge][x];
      if (kHasVoid && (number & kPendingVertex) != 0) {
        if (vertex_count_ == max_vertices_) {
          has_room = false;
          return 0U;
        }
        const EdgeOfCell& one = edges[odd_x][edge];
        vertices[vertex_count_] = vertex_at(x + one.x, y + one.y, z + one.z, one.direction,
                                            static_cast<int32_t>(number & ~kPendingVertex));
        number = vertex_count_++;
      }
      return number;
    };
    for (int i = 0; i < cell.polygons; ++i) {
      const CellPolygon& polygon = cell.polygon[i];
      if (kHasVoid && (polygon.tetrahedron & ~present_corners) != 0) continue;
      if (kHasVoid && polygon.corners - 2U > max_triangles_ - triangle_count_) {
        has_room = false;
        return;
      }
      const uint32_t p = vertex(polygon.edges[0]);
      const uint32_t q = vertex(polygon.edges[1]);
      const uint32_t r = vertex(polygon.edges[2]);
      const uint32_t s = polygon.corners == 3 ? r : vertex(polygon.edges[3]);
      if (!has_room) return;
      if (polygon.corners == 3) {
        triangles[triangle_count_++] = {{p, q, r}};
      } else if (is_cut_along_first(vertices[p], vertices[q], vertices[r], vertices[s])) {
        triangles[triangle_count_++] = {{p, q, r}};
        triangles[triangle_count_++] = {{p, r, s}};
      } else {
        triangles[triangle_count_++] = {{q, r, s}};
        triangles[triangle_count_++] = {{q, s, p}};
      }
    }
  });
  return has_room;
}

bool Marching::has_mixed_cells(int y, int z) const {
  const RowFilling kind = signs_->kind(y, z);
  return kind == RowFilling::kMixed || kind != signs_->kind(y + 1, z) ||
         kind != signs_->kind(y, z + 1) || kind != signs_->kind(y + 1, z + 1);
}

bool Marching::add_cells(int z, ShellVertex* vertices, ShellTriangle* triangles) {
  for (int y = 0; y + 1 < signs_->size(1); ++y) {
    if (!has_mixed_cells(y, z)) continue;
    const bool has_room = present_ == nullptr ? add_row_of_cells<false>(y, z, vertices, triangles)
                                              : add_row_of_cells<true>(y, z, vertices, triangles);
    if (!has_room) return false;
  }
  return true;
}

uint32_t Marching::count_triangles(int z) const {
  uint32_t triangles = 0;
  for (int y = 0; y + 1 < signs_->size(1); ++y) {
    if (!has_mixed_cells(y, z)) continue;
    const unsigned odd_y = static_cast<unsigned>(y + origin_[1]) & 1U;
    const unsigned odd_z = static_cast<unsigned>(z + origin_[2]) & 1U;
    const RowOfCells cells(*signs_, y, z, odd_y, odd_z);
    for_each_sample(cells.mixed() & not_last_, [&](int x) {
      const bool is_odd = ((x + origin_[0]) & 1) != 0;
      triangles += cases_->of[0][cells.corners(x, is_odd)].triangles;
    });
  }
  return triangles;
}

}  // namespace multitetra::shell
