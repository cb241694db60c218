// Creates vertices and triangles from the values, slice by slice, as core's OctreeCubeSurface does
// at a uniform level.
#pragma once

#include <stdint.h>

#include "common/codec/detail/cell_cases.hpp"
#include "common/codec/detail/crossed_edges.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/shell_format.hpp"
#include "common/codec/shell_mesh.hpp"

namespace multitetra::shell {

// Returns the steps from the edge's first end to the vertex, as core's lattice_vertex does, for
// values on different sides of c.
[[nodiscard]] inline int32_t exact_cut(double first, double last, double c, int32_t steps) {
  const double t = (c - first) / (last - first);
  const auto nearest = static_cast<int32_t>(t * steps + 0.5);
  return nearest < 1 ? 1 : nearest > steps - 1 ? steps - 1 : nearest;
}

// Returns whether the quad p, q, r, s (in cyclic order) is cut along pr: it is cut along the
// shorter diagonal or, if equal, the one with the least end by (x, y, z).
[[nodiscard]] bool is_cut_along_first(const ShellVertex& p, const ShellVertex& q,
                                      const ShellVertex& r, const ShellVertex& s);

class Marching {
 public:
  void begin(const BitField& signs, const BitField* present, const ShellHeader& header);

  // Adds vertices on the crossed edges of slice z with directions first .. end - 1. The steps from
  // an edge's start to its cut are `cut(x, y, direction)`. With void samples, some crossed edges
  // have no complete tetrahedron, so vertices are created when the first triangle uses them.
  // Returns false if there are more than the header declares.
  template <typename Cut>
  [[nodiscard]] bool add_vertices(const CrossedEdges& edges, int z, int first, int end,
                                  ShellVertex* vertices, const Cut& cut);

  // Adds the triangles of the cells between slices z and z + 1.
  [[nodiscard]] bool add_cells(int z, ShellVertex* vertices, ShellTriangle* triangles);

  // Returns the number of triangles between slices z and z + 1 if no sample is void.
  [[nodiscard]] uint32_t count_triangles(int z) const;

  [[nodiscard]] uint32_t vertices() const { return vertex_count_; }
  [[nodiscard]] uint32_t triangles() const { return triangle_count_; }

 private:
  using NumbersOfRow = uint32_t[kMaxShellSamples + 1];
  // Marks the entry of a vertex not created yet, which holds its cut instead of its index.
  static constexpr uint32_t kPendingVertex = 1U << 31;

  [[nodiscard]] ShellVertex vertex_at(int x, int y, int z, int direction, int32_t cut) const {
    const EdgeDirection d = kEdgeDirection[direction];
    return {.x = lattice_origin_[0] + x * steps_ + d.x * cut,
            .y = lattice_origin_[1] + y * steps_ + d.y * cut,
            .z = lattice_origin_[2] + z * steps_ + d.z * cut};
  }
  class RowOfCells;
  [[nodiscard]] bool has_mixed_cells(int y, int z) const;
  template <bool kHasVoid>
  bool add_row_of_cells(int y, int z, ShellVertex* vertices, ShellTriangle* triangles);

  const BitField* signs_ = nullptr;
  const BitField* present_ = nullptr;  // Null without void samples.
  const CellCases* cases_ = nullptr;
  int32_t origin_[3] = {};
  int32_t lattice_origin_[3] = {};
  int32_t steps_ = 2;
  uint32_t max_vertices_ = 0;
  uint32_t max_triangles_ = 0;
  uint32_t vertex_count_ = 0;
  uint32_t triangle_count_ = 0;
  RowBits not_last_;
  // The vertex index of each crossed edge.
  NumbersOfRow numbers_[2][kMaxShellSamples][kEdgeDirections];
};

template <typename Cut>
bool Marching::add_vertices(const CrossedEdges& edges, int z, int first, int end,
                            ShellVertex* vertices, const Cut& cut) {
  for (int y = 0; y < signs_->size(1); ++y) {
    if (!edges.any(y, z)) continue;
    for (int d = first; d < end; ++d) {
      const RowBits& crossed = edges.crossed(d, y, z);
      if (!crossed.any()) continue;
      uint32_t* const numbers = numbers_[z & 1][y][d];
      if (present_ != nullptr) {
        for_each_sample(crossed, [&](int x) {
          numbers[x] = kPendingVertex | static_cast<uint32_t>(cut(x, y, d));
        });
        continue;
      }
      if (static_cast<uint32_t>(count(crossed)) > max_vertices_ - vertex_count_) return false;
      for_each_sample(crossed, [&](int x) {
        vertices[vertex_count_] = vertex_at(x, y, z, d, cut(x, y, d));
        numbers[x] = vertex_count_++;
      });
    }
  }
  return true;
}

}  // namespace multitetra::shell
