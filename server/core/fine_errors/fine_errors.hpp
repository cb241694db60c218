// The field and the exact errors of spacings 1, 2 and 4 in one octree cube, for one isovalue. They
// are not in the error spectrum but computed from the samples during a query.
//
// Errors above the largest threshold are not computed: such a point *exceeds the threshold*, and so
// do its parents. Bit operations on whole layers decide this without arithmetic, and also skip
// points whose diamond the surface does not cross.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/fine_errors/detail/cell_bits.hpp"
#include "server/core/fine_errors/detail/fine_cells.hpp"
#include "server/core/framework/diamond_values.hpp"
#include "server/core/framework/row_kinds.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

struct FineErrorsOptions {
  double isovalue = 0;
  ErrorMeasure error_measure = ErrorMeasure::kCertified;
  TopologyRule rule = TopologyRule::kExact;
  double topology_tolerance = 0;  // In grid steps.
  // In world units. Errors above it are not computed exactly.
  double largest_threshold = std::numeric_limits<double>::infinity();
  // In grid steps, a power of two. Finer points have error 0 and add nothing to their parents.
  std::int32_t finest_spacing = 1;
};

// The working memory of FineErrors, about 30 MB for the largest cubes; reuse it. Its contents
// between uses are meaningless.
struct FineArrays {
  std::vector<float> values;
  // Errors of points that do not exceed the threshold.
  std::vector<float> errors;
  BitGrid above;   // Value greater than the isovalue.
  BitGrid below;   // Value neither above nor void.
  BitGrid mixed;   // Diamond with values on both sides.
  BitGrid active;  // Error other than 0.
  // The error is greater than the largest threshold.
  BitGrid exceeding;
};

// Not thread-safe.
class FineErrors {
 public:
  // The largest supported exponent of a cube.
  static constexpr int kMaxExponent = 7;

  // The volume and the arrays must outlive this object.
  FineErrors(const PreparedVolume& volume, const FineErrorsOptions& options, FineArrays& arrays);

  // Loads and computes the wanted cells of `cube`; `is_wanted` takes cells as octree cubes of
  // exponent kSpectrumExponent. Requires an exponent from kSpectrumExponent to kMaxExponent.
  void load(const OctreeCube& cube, const std::function<bool(const OctreeCube&)>& is_wanted);

  // Returns whether a cell of the cube is wanted.
  [[nodiscard]] bool is_wanted(const OctreeCube& cell) const { return cells_.is_wanted(cell); }

  // Returns the value of a point in a wanted closed cell, given its index().
  [[nodiscard]] float value(std::ptrdiff_t at) const {
    return arrays_.values[static_cast<std::size_t>(at)];
  }
  // Returns the error of such a point of spacing 1, 2 or 4; infinite if it exceeds the threshold,
  // or if a flip that is not tolerated keeps the point or a descendant.
  [[nodiscard]] float error(GridPoint p) const;
  // Returns a mask whose bit i + 3 j + 9 k is set if the point p + step * turned (i - 1, j - 1, k -
  // 1) exceeds the threshold. Requires p to be the center of an octree cube in a wanted cell, and a
  // step of at most half its side.
  [[nodiscard]] std::uint32_t exceeding_neighbours(GridPoint p, std::int32_t step,
                                                   const std::array<std::int32_t, 3>& turned) const;
  [[nodiscard]] std::ptrdiff_t index(GridPoint p) const {
    const GridPoint at = p - origin_;
    return at.x + row_ * at.y + slice_ * at.z;
  }
  [[nodiscard]] std::ptrdiff_t row() const { return row_; }
  [[nodiscard]] std::ptrdiff_t slice() const { return slice_; }

 private:
  static constexpr std::int32_t kCell = kSpectrumSpacing;

  // Array offsets to the children of one kind of point.
  struct Children {
    std::size_t count = 0;
    std::array<std::ptrdiff_t, 8> offsets{};
  };

  void begin_arrays();
  void make_offsets();
  void load_signs(const FineCell& cell);
  void find_mixed_diamonds(const FineCell& cell);
  void compute(int exponent);
  void compute_kind(const FineCell& cell, int exponent, PointKind kind);
  void compute_points(const FineCell& cell, std::int32_t z, BitPlane points, BitPlane mixed,
                      int exponent, PointKind kind);
  [[nodiscard]] std::size_t bits_of(const FineCell& cell) const;
  [[nodiscard]] static std::size_t row_index(PointKind kind, GridPoint unit_point) {
    return static_cast<std::size_t>(kind) * 4 +
           static_cast<std::size_t>((unit_point.y & 1) | (unit_point.z & 1) << 1);
  }
  [[nodiscard]] float largest_error(const Children& children, std::ptrdiff_t at) const;
  [[nodiscard]] float with_own_error(GridPoint p, std::ptrdiff_t at, int exponent,
                                     float below) const;
  void load_diamond(GridPoint p, std::ptrdiff_t at, int exponent, DiamondValues<double>& d) const;

  const PreparedVolume& volume_;
  const FineErrorsOptions options_;
  // A float exceeds the isovalue exactly if it exceeds this.
  const float isovalue_below_;
  const float threshold_below_;  // The same for the largest threshold.
  FineCells cells_;
  GridPoint origin_;  // Grid coordinates of the arrays' first point: one cell below the cube.
  // Side of the cube in grid steps.
  std::int32_t side_ = 0;
  std::ptrdiff_t row_ = 0;  // Strides of the arrays.
  std::ptrdiff_t slice_ = 0;
  FineArrays& arrays_;
  std::array<std::array<Children, 12>, kSpectrumExponent> children_{};  // By spacing and row_index.
  std::array<DiamondLengths<double>, kSpectrumExponent> lengths_{};     // By spacing.
  // By shape, for spacing 1.
  std::array<std::array<std::ptrdiff_t, Diamond::kMaxCorners>, 64> offsets_{};
};

}  // namespace multitetra
