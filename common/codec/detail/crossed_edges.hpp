// Finds the edges that start at a slice's samples and are crossed by the surface, from the signs
// alone and a row at a time.
//
// At a uniform level every cell is divided into six tetrahedra around the diagonal from its corner
// with even coordinates to the one with odd coordinates. So every sample has edges along the axes;
// it has an edge to the neighbour along a face diagonal if both changing coordinates have the same
// parity, along a cube diagonal if all three have. Coordinates are those of the grid, in units of
// the spacing.
#pragma once

#include <stdint.h>

#include "common/codec/detail/row_bits.hpp"

namespace multitetra::shell {

// The direction of an edge, from the end at which it ascends in z, or else in y, or else in x.
struct EdgeDirection {
  int8_t x;
  int8_t y;
  int8_t z;
};
inline constexpr int kEdgeDirections = 13;
inline constexpr int kDirectionsInSlice = 4;  // The first ones; the others lead to the next slice.
inline constexpr EdgeDirection kEdgeDirection[kEdgeDirections] = {
    {1, 0, 0}, {0, 1, 0}, {1, 1, 0},  {-1, 1, 0}, {0, 0, 1},  {1, 0, 1},  {-1, 0, 1},
    {0, 1, 1}, {1, 1, 1}, {-1, 1, 1}, {0, -1, 1}, {1, -1, 1}, {-1, -1, 1}};

// Returns whether core's lattice_vertex takes the other end as the first.
[[nodiscard]] constexpr bool begins_at_other_end(EdgeDirection d) {
  return 4 * d.x + 2 * d.y + d.z < 0;
}

// The crossed edges of two adjacent slices, z and either z - 1 or z + 1.
class CrossedEdges {
 public:
  // `origin` is the box's lowest corner in grid coordinates, in spacings.
  void begin(const BitField& signs, const BitField* present, const int32_t (&origin)[3]);

  // Finds the crossed edges that start in slice z, and thereby all active samples of the slice,
  // those at an end of a crossed edge. Requires ascending slices.
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
  const BitField* present_ = nullptr;  // Null without void samples.
  int32_t origin_[3] = {};
  RowBits inside_;
  RowBits not_last_;
  RowBits not_first_;
  RowBits even_;  // The samples with even x.
  bool any_[2][kMaxShellSamples] = {};
  RowBits crossed_[2][kMaxShellSamples][kEdgeDirections];
  RowBits active_[2][kMaxShellSamples];
};

}  // namespace multitetra::shell
