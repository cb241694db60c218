// Bounds of the errors of a volume whose spectrum is missing, from the ranges of its cells.
//
// The values that decide the errors of a point p and of its descendants lie in the box B(p)
// (region() in error_based_model.hpp). If all of them are on one side of the isovalue, these errors
// are 0; otherwise they are unknown: infinite, with a flip of p's own spacing. B of a child lies
// inside B of its parents, so bounds never decrease from children to parents, and models conform.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "server/core/errors/saturated_errors.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

struct PreparedVolume;

// The bounds for one isovalue. Thread-safe. Takes two bytes per cell.
class UnknownErrors {
 public:
  UnknownErrors(const PreparedVolume& volume, double isovalue);

  // Requires point.spacing() >= kSpectrumSpacing.
  [[nodiscard]] ErrorBound bound(const DividingPoint& point) const;

 private:
  // The sides of the isovalue on which a cube has values; void values are on neither.
  using Sides = std::uint8_t;
  static constexpr Sides kAbove = 1;
  static constexpr Sides kNotAbove = 2;
  static constexpr Sides kBoth = kAbove | kNotAbove;

  struct Level {
    LevelExtent extent;  // The cubes of side 2^exponent that contain data.
    std::vector<Sides> sides;
  };
  [[nodiscard]] Sides sides_of(double value) const {
    return value > isovalue_ ? kAbove : kNotAbove;
  }
  template <typename Sample>
  void add_cells(const PreparedVolume& volume);
  void add_coarser_level();
  [[nodiscard]] Sides sides_in(const DividingPoint& point) const;

  double isovalue_;
  Sides outside_ = 0;  // Of the value beyond the data.
  SpectrumLayout layout_;
  std::vector<Level> levels_;  // From cells of side kSpectrumSpacing on.
  // By place in the layout: 0 until first use, 1 without errors, 2 unknown.
  mutable std::vector<std::atomic<std::uint8_t>> found_;
};

}  // namespace multitetra
