// Slices that are not on a rectangular grid: shifted against each other as by a tilted gantry or in
// a sheared grid, or unevenly spaced; and the rectangular grid to which they are resampled.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/affine.hpp"

namespace multitetra {

struct ImageHeader;

// Positions of stored slices on a rectangular grid. Sample (column, row) of slice i is at
// x = column + shift[i][0] + row_shift * row, y = row + shift[i][1], z = at[i], in grid steps.
struct SlicePlaces {
  std::array<std::int64_t, 2> size{};  // Columns and rows of the slices.
  std::vector<double> at;              // Increasing.
  std::vector<std::array<double, 2>> shift;
  double row_shift = 0;
  std::array<std::int64_t, 3> dims{};  // Of the grid.

  // Sets dims[0] and dims[1] to those of the smallest grid around all slices, and moves the shifts
  // to it. Shifts by nearly whole samples become whole, so that they need no interpolation. Returns
  // by how many samples the grid's first sample precedes the origin of the given shifts.
  std::array<double, 2> fit_grid();
};

// Returns whether the axes are at right angles to within 1 part in 1000.
[[nodiscard]] bool has_right_angles(const ImageHeader& header);

// Throws VolumeFileError unless they are: errors would not be lengths in the world.
void check_right_angles(const std::filesystem::path& file, const ImageHeader& header);

// Makes the axes of a sheared grid rectangular: the first one stays, the others lose their shear.
// Returns the places of the slices on that grid. Requires a header that check_header() accepts.
[[nodiscard]] SlicePlaces straighten(ImageHeader& header);

}  // namespace multitetra
