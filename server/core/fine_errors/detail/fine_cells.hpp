// The cells that FineErrors has to evaluate for one octree cube.
//
// Only *wanted* cells are computed: those in which the model goes beyond the spectrum, because all
// three parents of the cell's centre are kept. What they need lies in the cells around them, which
// a cell's least and largest sample let it pass over as long as no surface is near:
//
//     . . . . . .      w  wanted cell
//     . s s s . .      s  support: loaded, and computed as far as a wanted cell needs it
//     . s w s s .
//     . s s w s .
//     . . s s s .
//
// The diamonds of all points in a closed wanted cell, and of their descendants, reach seven steps
// beyond it; a cell has eight.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// A support cell; its own points are those with offsets 0 to 7 from `low`.
struct FineCell {
  GridPoint low;
  bool is_crossed;  // Diamonds of its points may have values on both sides of the isovalue.
  bool is_near;     // Those of their descendants may: it or a neighbour is crossed.
};

class FineCells {
 public:
  // The volume must outlive it.
  FineCells(const PreparedVolume& volume, double isovalue);

  // `is_wanted` takes cells as octree cubes of exponent kSpectrumExponent. Requires a cube of at
  // least that exponent.
  void find(const OctreeCube& cube, const std::function<bool(const OctreeCube&)>& is_wanted);

  // Empty when nothing is wanted.
  [[nodiscard]] const std::vector<FineCell>& support() const { return support_; }
  // Whether a cell of the cube is wanted.
  [[nodiscard]] bool is_wanted(const OctreeCube& cell) const {
    return wanted_[index(GridPoint{cell.x, cell.y, cell.z} - first_)];
  }

 private:
  [[nodiscard]] bool may_cross(GridPoint cell) const;
  [[nodiscard]] std::size_t index(GridPoint cell) const {
    return static_cast<std::size_t>(cell.x + cells_ * (cell.y + cells_ * cell.z));
  }
  bool mark_wanted(const std::function<bool(const OctreeCube&)>& is_wanted);
  void mark_crossed();
  template <typename Visit>
  void visit_cells(std::int32_t begin, std::int32_t end, const Visit& visit) const;

  const PreparedVolume& volume_;
  const LevelExtent in_data_;
  const float outside_;
  const float isovalue_below_;  // A float is above the isovalue exactly when it is above this one.
  GridPoint first_;             // The cell below the cube.
  std::int32_t cells_ = 0;      // Along an axis: the cube's and one on either side.
  std::span<const std::byte> ranges_;  // The volume's.
  std::vector<bool> wanted_;           // By cell.
  std::vector<std::uint8_t> is_support_;
  std::vector<std::uint8_t> is_crossed_;
  std::vector<FineCell> support_;
};

}  // namespace multitetra
