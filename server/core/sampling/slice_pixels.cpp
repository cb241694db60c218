#include "server/core/sampling/slice_pixels.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/core/sampling/sample_reader.hpp"

namespace multitetra {
namespace {

// Fills a row along x with the nearest samples. Requires y and z in the data. Nearly all pixels of
// boxes are in such rows, where only x needs to be converted.
template <typename Reader>
void fill_row_along_x(Reader& reader, const DatasetInfo& info, const Vec3& left, double step,
                      std::span<float> values) {
  const std::int32_t y = nearest_sample(reader.along(1, left[1]));
  const std::int32_t z = nearest_sample(reader.along(2, left[2]));
  const double last = info.dims[0] - 1;
  if constexpr (requires { reader.fill_row(GridPoint{}, 1, values); }) {
    const double first = snapped_to_sample(left[0]);
    const double end = first + step * static_cast<double>(values.size() - 1);
    if (step >= 1 && step <= last + 1 && step == std::floor(step) && first == std::floor(first) &&
        first >= 0 && end <= last) {
      reader.fill_row({static_cast<std::int32_t>(first), y, z}, static_cast<std::int32_t>(step),
                      values);
      return;
    }
  }
  for (std::size_t column = 0; column < values.size(); ++column) {
    const double x = snapped_to_sample(left[0] + static_cast<double>(column) * step);
    const bool is_inside = x >= 0 && x <= last;
    values[column] = is_inside ? reader.at({nearest_sample(reader.along(0, x)), y, z}) : kNoField;
  }
}

template <typename Reader>
void fill_rows(Reader reader, const DatasetInfo& info, const SliceRequest& plane,
               std::uint32_t first_row, std::uint32_t rows, std::span<float> values) {
  for (std::uint32_t layer = 0; layer < plane.layers; ++layer) {
    const Vec3 origin = moved(plane.origin, layer, plane.inward);
    for (std::uint32_t row = first_row; row < first_row + rows; ++row) {
      std::size_t pixel = layer * plane.pixels_of_layer() + std::size_t{row} * plane.width;
      const Vec3 left = moved(origin, row, plane.down);
      if (plane.interpolation == Interpolation::kNearest && plane.right[1] == 0 &&
          plane.right[2] == 0 && is_in_data({0, left[1], left[2]}, info)) {
        fill_row_along_x(reader, info, left, plane.right[0], values.subspan(pixel, plane.width));
        continue;
      }
      for (std::uint32_t column = 0; column < plane.width; ++column, ++pixel) {
        const Vec3 index = moved(left, column, plane.right);
        if (!is_in_data(index, info)) {
          values[pixel] = kNoField;
          continue;
        }
        const Vec3 place = reader.unit_place(index);
        values[pixel] = plane.interpolation == Interpolation::kNearest
                            ? nearest_value(reader, place)
                            : static_cast<float>(linear_value(reader, place));
      }
    }
  }
}

}  // namespace

double bricks_crossed(const SliceRequest& plane, const DatasetInfo& info) {
  constexpr double kBrickFace = BrickLayout::kSampleSide * BrickLayout::kSampleSide;
  // For each axis along which its normal has a component, a plane crosses a layer of bricks, but no
  // more bricks than the data has there.
  const Vec3 area =
      scaled(cross(plane.right, plane.down), static_cast<double>(plane.pixels_of_layer()));
  double faces = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double widest = static_cast<double>(info.dims[(axis + 1) % 3]) *
                          static_cast<double>(info.dims[(axis + 2) % 3]);
    faces += std::min(std::abs(area[axis]), widest) / kBrickFace;
  }
  // Layers within one side of a brick share bricks.
  const double depth = (plane.layers - 1) * length(plane.inward) / BrickLayout::kSampleSide;
  faces *= std::min(static_cast<double>(plane.layers), depth + 1);
  // A pixel lies between at most eight bricks.
  return std::min(faces, 8.0 * static_cast<double>(plane.pixels()));
}

std::int32_t slice_spacing(const SliceRequest& plane, const DatasetInfo& info) {
  if (plane.detail == SliceDetail::kFull || !has_coarse_samples(info)) return 1;
  if (plane.detail == SliceDetail::kCoarse) return kSpectrumSpacing;
  const double apart = std::min(length(plane.right), length(plane.down));
  const bool is_as_good = apart >= 0.5 * kSpectrumSpacing;
  return is_as_good || bricks_crossed(plane, info) > kMaxSliceBricks ? kSpectrumSpacing : 1;
}

void slice_rows(const PreparedVolume& volume, const SliceRequest& plane, std::int32_t spacing,
                std::uint32_t first_row, std::uint32_t rows, std::span<float> values) {
  assert(plane.coordinates == CoordinateSystem::kIndex);
  assert(first_row + rows <= plane.height && values.size() == plane.pixels());
  visit_type(volume.info.type, [&]<typename Sample>(const Sample*) {
    if (spacing == 1) {
      fill_rows(BrickReader<Sample>(volume), volume.info, plane, first_row, rows, values);
    } else {
      fill_rows(CoarseReader<Sample>(volume), volume.info, plane, first_row, rows, values);
    }
  });
}

}  // namespace multitetra
