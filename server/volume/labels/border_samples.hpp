// Finds the border samples of a label map and their first magnitudes (see label_borders.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace multitetra {

// Numbers of samples along x, y and z.
using LabelDims = std::array<std::int32_t, 3>;
[[nodiscard]] constexpr std::size_t slice_samples(const LabelDims& dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
}
// Reads the labels of slice z.
using ReadLabels = std::function<void(std::int32_t z, std::span<std::int32_t> into)>;

// Marks void samples, and those of a layer beyond the ends of the map.
inline constexpr std::int32_t kVoidLabel = std::numeric_limits<std::int32_t>::min();
inline constexpr std::int32_t kBeyondMap = kVoidLabel + 1;

// Range of magnitudes, in 1/256 of the field's range.
inline constexpr int kMinMagnitude = 4;
inline constexpr int kMaxMagnitude = 127;
// The magnitude of samples next to a plane border, and of all beyond the map.
inline constexpr int kWallMagnitude = 36;

struct BorderSample {
  // kMinMagnitude to kMaxMagnitude; 0 for samples that are not at a border.
  std::uint8_t magnitude : 7 = 0;
  // Whether the label has a cube of 5 x 5 x 5 samples, with this sample in it or at most one sample
  // away along each axis. Always set beyond the map.
  std::uint8_t is_thick : 1 = 0;
};
static_assert(sizeof(BorderSample) == 1);

// Goes once through all slices, in order.
//
// The magnitude is the greater of two measures:
// * The smoothed indicator of the sample's label minus one half. It smooths steps that are a few
//   samples apart.
// * For terraces, which coarse slices cause: the distance to the nearest sample of another label in
//   one of the planes x, y or z = constant through the sample (the greatest of the three). On the
//   edges between two terraces, the border then rises from the edge of one to the edge of the
//   other, as in the shape-based interpolation of Raya and Udupa (1990), here along all axes.
class BorderSearch {
 public:
  // Keeps a reference to `read`.
  BorderSearch(const LabelDims& dims, const ReadLabels& read);

  // Returns the number of border samples in the next slice.
  std::uint32_t next(std::span<BorderSample> into);

 private:
  // The largest distance at which the edge of a terrace is searched for, in samples.
  static constexpr std::int32_t kTerraceReach = 6;
  static constexpr std::size_t kSlices = 2 * kTerraceReach + 1;

  struct Slice {
    std::vector<std::int32_t> labels;
    std::vector<std::uint8_t> is_border;
    // Whether the sample is in the middle of a square of 5 x 5 samples of its label in the slice,
    // and of a cube.
    std::vector<std::uint8_t> is_square;
    std::vector<std::uint8_t> is_cube;
  };
  // A step within a plane of the grid.
  struct PlaneStep {
    std::int32_t u = 0;
    std::int32_t v = 0;
    double length = 0;
  };

  static std::vector<PlaneStep> plane_steps();
  Slice& slice(std::int32_t z) { return slices_[static_cast<std::size_t>(z) % kSlices]; }
  [[nodiscard]] std::size_t place(std::int32_t x, std::int32_t y) const;
  void load(std::int32_t z);
  void mark_borders(Slice& lower, Slice& upper) const;
  void find_squares(Slice& slice) const;
  void find_cubes(std::int32_t z);
  [[nodiscard]] int smoothed_magnitude(const LabelDims& at, std::int32_t label);
  [[nodiscard]] int terrace_magnitude(const LabelDims& at, std::int32_t label);
  [[nodiscard]] bool is_thick(const LabelDims& at, std::int32_t label);

  LabelDims dims_;
  const ReadLabels& read_;
  std::vector<PlaneStep> steps_ = plane_steps();
  std::int32_t next_ = 0;
  std::int32_t loaded_ = 0;  // Number of slices loaded.
  std::array<Slice, kSlices> slices_;
};

}  // namespace multitetra
