// The edges of the cells that begin at a slice's samples, and those that the surface crosses: from
// the signs alone, whole rows at a time.
//
// At a uniform level every cell is cut into six tetrahedra around the diagonal from its corner with
// even coordinates to the one with odd ones. So every sample begins edges along the axes; between
// (x, y, z) and its neighbour along a face diagonal there is an edge when both coordinates that
// change have the same parity, along a cube diagonal when all three have. That is in units of the
// spacing, in coordinates of the grid.
#pragma once

#include <stdint.h>

#include "common/codec/detail/row_bits.hpp"

namespace multitetra::shell {

// Every edge is known by the end from which it goes up in z, else in y, else in x.
struct EdgeDirection {
  int8_t x;
  int8_t y;
  int8_t z;
};
inline constexpr int kEdgeDirections = 13;
inline constexpr int kDirectionsInSlice = 4;  // The first ones; the others go to the next slice.
inline constexpr EdgeDirection kEdgeDirection[kEdgeDirections] = {
    {1, 0, 0}, {0, 1, 0}, {1, 1, 0},  {-1, 1, 0}, {0, 0, 1},  {1, 0, 1},  {-1, 0, 1},
    {0, 1, 1}, {1, 1, 1}, {-1, 1, 1}, {0, -1, 1}, {1, -1, 1}, {-1, -1, 1}};

// Where core's lattice_vertex calls the other end the first one.
[[nodiscard]] constexpr bool begins_at_other_end(EdgeDirection d) {
  return 4 * d.x + 2 * d.y + d.z < 0;
}

// The crossed edges of two slices at a time: z and, above it, z - 1 or z + 1.
class CrossedEdges {
 public:
  // `origin`: grid coordinates of the box's lowest corner, in spacings.
  void begin(const BitField& signs, const BitField* present, const int32_t (&origin)[3]);

  // Finds the crossed edges that begin in slice z, and with them all active samples of the slice:
  // those at the end of a crossed edge. Slices in ascending order.
  void find(int z);

  [[nodiscard]] bool any(int y, int z) const { return any_[z & 1][y]; }
  [[nodiscard]] const RowBits& crossed(int direction, int y, int z) const {
    return crossed_[z & 1][y][direction];
  }
  [[nodiscard]] RowBits active(int y, int z) const { return active_[z & 1][y]; }

 private:
  template <bool kHasVoid>
  void find_in_row(int y, int z);
  [[nodiscard]] bool is_uniform_around(int y, int z) const;
  [[nodiscard]] RowBits presence(int y, int z) const {
    return present_ == nullptr ? inside_ : present_->row(y, z);
  }

  const BitField* signs_ = nullptr;
  const BitField* present_ = nullptr;  // Without void samples there is none.
  int32_t origin_[3] = {};
  RowBits inside_;
  RowBits not_last_;
  RowBits not_first_;
  RowBits even_;  // Samples with even x.
  bool any_[2][kMaxShellSamples] = {};
  RowBits crossed_[2][kMaxShellSamples][kEdgeDirections];
  RowBits active_[2][kMaxShellSamples];
};

}  // namespace multitetra::shell
