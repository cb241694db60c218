// Volumes inside the arrays of a container: which array and which of its dimensions, placed and
// scaled by the conventions of conventions.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/arrays/conventions.hpp"

namespace multitetra {

// The array's dimensions that are the volume's axes x, y and z (without z: one slice), the numbers
// of a sample (if they are a dimension), and the position along the others.
struct VolumeInArray {
  std::array<std::optional<std::size_t>, 3> axes;
  std::vector<std::int64_t> at;  // One per dimension; ignored for the axes and the component.
  std::optional<std::size_t> component = std::nullopt;
  StoredType type = StoredType::kU8;  // Of the numbers in the file, with the sign that they have.
  // Slope and intercept of each slice, if they differ; the slices are then f32.
  std::vector<std::array<double, 2>> scales = {};
  // A number that may stand for samples that were never written, and the notice if it occurs.
  std::optional<double> unwritten = std::nullopt;
  std::string unwritten_notice = {};
};

// Returns the array of choice.array, or the only one that the file offers. Throws VolumeFileError
// if there is none or several; with choice.first takes the largest of several.
[[nodiscard]] std::string chosen_array(const ArrayContainer& file, const VolumeChoice& choice);

// Returns all of a volume but its slices, and sets where it lies in the array. With
// `has_components`, the numbers of a sample may be a dimension; else they are channels. Throws
// VolumeFileError if a choice is required, or the array is not a volume.
[[nodiscard]] StoredVolume described_volume(const ArrayContainer& file, const std::string& array,
                                            ArrayMeaning meaning, const VolumeChoice& choice,
                                            bool has_components, VolumeInArray& place);

// Reads boxes of an array in the order of the file, in host byte order.
class ArrayReader {
 public:
  virtual ~ArrayReader() = default;
  // Throws VolumeFileError.
  virtual void read(const std::vector<std::int64_t>& start, const std::vector<std::int64_t>& extent,
                    std::byte* into) = 0;
};

// Returns the slices of a volume in an array of this shape. Dimensions in another order than z, y,
// x are read in blocks of slices and transposed.
[[nodiscard]] std::unique_ptr<StoredSlices> array_slices(std::unique_ptr<ArrayReader> reader,
                                                         std::vector<std::int64_t> shape,
                                                         VolumeInArray place);

// Lists the arrays of the file in `contents`: all as entries, those of the same shape as fields.
void list_arrays(const ArrayContainer& file, const std::string& array, VolumeContents& contents);

}  // namespace multitetra
