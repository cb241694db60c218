// The cells that FineErrors must evaluate for one octree cube.
//
// Only *wanted* cells are computed: those that the model refines beyond the spectrum, because it
// keeps all three parents of the cell's center. They depend on the cells around them; of these,
// cells far from the surface are skipped by their least and largest sample:
//
//     . . . . . .      w  wanted cell
//     . s s s . .      s  support: loaded, and computed as far as a wanted cell needs it
//     . s w s s .
//     . . s w s .
//     . . s s s .
//
// The diamonds of all points in a closed wanted cell, and of their descendants, extend seven steps
// beyond it; a cell has eight.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// A support cell; it owns the points at offsets 0 to 7 from `low`.
struct FineCell {
  GridPoint low;
  // The diamonds of its points may have values on both sides of the isovalue.
  bool is_crossed;
  // The diamonds of their descendants may: the cell or a neighbour is crossed.
  bool is_near;
};

class FineCells {
 public:
  // The volume must outlive this object.
  FineCells(const PreparedVolume& volume, double isovalue);

  // Finds the support cells of a cube. `is_wanted` takes cells as octree cubes of exponent
  // kSpectrumExponent. Requires a cube of at least that exponent.
  void find(const OctreeCube& cube, const std::function<bool(const OctreeCube&)>& is_wanted);

  // Empty if no cell is wanted.
  [[nodiscard]] const std::vector<FineCell>& support() const { return support_; }
  // Returns whether a cell of the cube is wanted.
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
  // A float exceeds the isovalue exactly if it exceeds this.
  const float isovalue_below_;
  GridPoint first_;                    // The cell below the cube.
  std::int32_t cells_ = 0;             // Cells along an axis: the cube's and one on either side.
  std::span<const std::byte> ranges_;  // Ranges of the volume's cells.
  std::vector<bool> wanted_;           // By cell.
  std::vector<std::uint8_t> is_support_;
  std::vector<std::uint8_t> is_crossed_;
  std::vector<FineCell> support_;
};

}  // namespace multitetra
