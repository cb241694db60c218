#include "server/volume/formats/slice_places.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "common/base/vec3.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::array<std::pair<std::size_t, std::size_t>, 3> kPairs = {{{0, 1}, {0, 2}, {1, 2}}};
constexpr double kMaxCosine = 1e-3;
constexpr double kNearlyWhole = 0.01;  // Samples.
constexpr double kManySamples = 1e12;  // More than any grid may have along an axis.

bool are_at_right_angles(const Vec3& a, const Vec3& b) {
  return std::abs(dot(a, b)) <= kMaxCosine * length(a) * length(b);
}

}  // namespace

std::array<double, 2> SlicePlaces::fit_grid() {
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  const double last_row_shift = row_shift * static_cast<double>(size[1] - 1);
  const std::array<double, 2> least_row_shift = {std::min(0.0, last_row_shift), 0};
  const std::array<double, 2> largest_row_shift = {std::max(0.0, last_row_shift), 0};
  for (auto& of_slice : shift) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double& by = of_slice[axis];
      if (std::abs(by - std::round(by)) < kNearlyWhole) by = std::round(by);
      low[axis] = std::min(low[axis], std::floor(by + least_row_shift[axis]));
      high[axis] = std::max(high[axis], std::ceil(by + largest_row_shift[axis]));
    }
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (auto& of_slice : shift) of_slice[axis] -= low[axis];
    const double count = static_cast<double>(size[axis]) + high[axis] - low[axis];
    dims[axis] = static_cast<std::int64_t>(count < kManySamples ? count : kManySamples);
  }
  return low;
}

bool has_right_angles(const ImageHeader& header) {
  const std::array<Vec3, 3>& steps = header.geometry.axes;
  return std::all_of(kPairs.begin(), kPairs.end(), [&](const auto& pair) {
    return are_at_right_angles(steps[pair.first], steps[pair.second]);
  });
}

void check_right_angles(const std::filesystem::path& file, const ImageHeader& header) {
  const std::array<Vec3, 3>& steps = header.geometry.axes;
  for (const auto& [a, b] : kPairs) {
    if (are_at_right_angles(steps[a], steps[b])) continue;
    fail_reading(file,
                 "its axes " + std::to_string(a + 1) + " and " + std::to_string(b + 1) +
                     " are not at right angles to each other (a sheared grid or a tilted gantry)",
                 "Resample it onto a rectangular grid with --resample");
  }
}

SlicePlaces straighten(ImageHeader& header) {
  std::array<Vec3, 3>& steps = header.geometry.axes;
  const auto part_along = [](const Vec3& step, const Vec3& axis) {
    return dot(step, axis) / squared_length(axis);
  };
  SlicePlaces places{
      .size = {header.dims[0], header.dims[1]}, .at = {}, .shift = {}, .dims = header.dims};
  if (!are_at_right_angles(steps[0], steps[1])) places.row_shift = part_along(steps[1], steps[0]);
  steps[1] = moved(steps[1], -places.row_shift, steps[0]);
  const std::array<double, 2> step_shift = {part_along(steps[2], steps[0]),
                                            part_along(steps[2], steps[1])};
  for (std::size_t axis = 0; axis < 2; ++axis)
    steps[2] = moved(steps[2], -step_shift[axis], steps[axis]);
  for (std::int64_t i = 0; i < header.dims[2]; ++i) {
    const auto slice = static_cast<double>(i);
    places.at.push_back(slice);
    places.shift.push_back({slice * step_shift[0], slice * step_shift[1]});
  }
  const std::array<double, 2> low = places.fit_grid();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::optional<double>& origin = header.geometry.origin[axis];
    if (origin) *origin += low[0] * steps[0][axis] + low[1] * steps[1][axis];
    std::optional<double>& spacing = header.geometry.spacing[axis];
    if (spacing) spacing = length(steps[axis]);
  }
  return places;
}

}  // namespace multitetra
