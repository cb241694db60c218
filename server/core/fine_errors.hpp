// The field and the exact errors of spacings 1, 2 and 4 in one octree cube, for one isovalue: what
// the error spectrum leaves out, computed from the samples when a query needs it.
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

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "common/isosurface_request.hpp"
#include "common/octree_cube.hpp"
#include "server/core/diamond_values.hpp"
#include "server/core/mixed_diamonds.hpp"
#include "server/core/prepared_volume.hpp"
#include "server/core/step_lengths.hpp"

namespace multitetra {

struct FineErrorsOptions {
  double isovalue = 0;
  ErrorMeasure measure = ErrorMeasure::kCertified;
  TopologyRule rule = TopologyRule::kExact;
  double topology_tolerance = 0;  // Grid steps.
  // World units. An error above it says no more than that: what a point adds to children that are
  // above it already is not computed.
  double largest_threshold = std::numeric_limits<double>::infinity();
};

// The memory of FineErrors, some 30 MB for the largest cubes: worth to be used again. What it holds
// between two uses means nothing.
struct FineArrays {
  std::vector<float> values;
  std::vector<float> errors;
  // A bit per point, behind and before some unused bytes:
  std::vector<std::uint8_t> above;  // Its value is greater than the isovalue.
  std::vector<std::uint8_t> below;  // It is not, and it is not void.
  std::vector<std::uint8_t> mixed;  // Its diamond has values of both kinds.
};

// One thread at a time.
class FineErrors {
 public:
  // Cubes of at most this exponent.
  static constexpr int kMaxExponent = 7;

  // The volume and the arrays must outlive it.
  FineErrors(const PreparedVolume& volume, const FineErrorsOptions& options, FineArrays& arrays);

  // Loads and computes what is wanted in `cube`; `is_wanted` takes cells as octree cubes of
  // exponent kSpectrumExponent. Requires an exponent from kSpectrumExponent to kMaxExponent.
  void load(const OctreeCube& cube, const std::function<bool(const OctreeCube&)>& is_wanted);

  // Whether a cell of the cube is wanted.
  [[nodiscard]] bool is_wanted(const OctreeCube& cell) const;

  // Of points in a wanted closed cell, by index().
  [[nodiscard]] float value(std::ptrdiff_t at) const {
    return arrays_.values[static_cast<std::size_t>(at)];
  }
  // The error, infinite when a flip that is not tolerated keeps the point or a descendant; where it
  // is above the largest threshold, some lower bound that is above it too. For points of spacing 1,
  // 2 or 4.
  [[nodiscard]] float error(std::ptrdiff_t at) const {
    return arrays_.errors[static_cast<std::size_t>(at)];
  }
  [[nodiscard]] std::ptrdiff_t index(GridPoint p) const {
    const GridPoint at = p - origin_;
    return at.x + row_ * at.y + slice_ * at.z;
  }
  [[nodiscard]] std::ptrdiff_t row() const { return row_; }
  [[nodiscard]] std::ptrdiff_t slice() const { return slice_; }

 private:
  static constexpr std::int32_t kCell = kSpectrumSpacing;

  // One cell of the array; its points are those with offsets 0 to 7 from `low`.
  struct Cell {
    GridPoint low;
    std::ptrdiff_t at;  // index(low)
    bool is_crossed;    // Diamonds of its points may have values on both sides of the isovalue.
    bool is_near;       // Those of their descendants may: it or a neighbour is crossed.
  };
  void find_cells(const std::function<bool(const OctreeCube&)>& is_wanted);
  [[nodiscard]] bool may_cross(GridPoint cell) const;
  template <typename Sample>
  void load_values(const Sample*);
  template <typename Sample>
  void load_cell(const Cell& cell);
  void load_signs(const Cell& cell);
  void make_offsets();
  void compute(int exponent);
  void compute_kind(const Cell& cell, int exponent, PointKind kind);
  void compute_row(GridPoint first, unsigned bits, int exponent, const RowKind& shape);
  void find_mixed_diamonds(const Cell& cell);
  // Where the bits of the eight points from `at` on are.
  [[nodiscard]] std::size_t byte_of(std::ptrdiff_t at) const {
    return static_cast<std::size_t>(unused_bytes_ + at / 8);
  }
  [[nodiscard]] float with_own_error(GridPoint p, std::ptrdiff_t at, int exponent,
                                     float below) const;
  void load_diamond(GridPoint p, std::ptrdiff_t at, int exponent, DiamondValues<double>& d) const;

  const PreparedVolume& volume_;
  const FineErrorsOptions options_;
  const LevelExtent cells_in_data_;
  const float outside_;
  const float isovalue_below_;  // A float is above the isovalue exactly when it is above this one.
  const float settled_above_;   // As for the isovalue, of the largest threshold.
  GridPoint origin_;        // Grid coordinates of the arrays' first point: one cell below the cube.
  std::int32_t side_ = 0;   // Of the cube, grid steps.
  std::int32_t cells_ = 0;  // Of the array along an axis.
  std::ptrdiff_t row_ = 0;  // Strides of the arrays.
  std::ptrdiff_t slice_ = 0;
  std::ptrdiff_t unused_bytes_ = 0;  // At both ends of the bits.
  FineArrays& arrays_;
  std::vector<bool> wanted_;  // By cell of the array.
  std::vector<Cell> support_;
  std::array<DiamondLengths<double>, kSpectrumExponent> lengths_{};             // By spacing.
  std::array<std::array<std::ptrdiff_t, Diamond::kMaxCorners>, 64> offsets_{};  // By shape, for
                                                                                // spacing 1.
};

}  // namespace multitetra
