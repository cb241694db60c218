#include "server/volume/formats/dicom/detail/dicom_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Maximum deviation of a slice from an even grid, in steps.
constexpr double kOnGrid = 0.1;
// Minimum deviation for a notice, in steps.
constexpr double kReportedDeviation = 0.01;
constexpr double kTilt = 1e-3;  // Minimum cosine of an axis and the slice step.
// Maximum number of slices of an interpolated grid.
constexpr double kMaxSlices = 1e5;

double median_gap(const std::vector<DicomImage>& stack) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < stack.size(); ++i)
    gaps.push_back(stack[i].along - stack[i - 1].along);
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

[[noreturn]] void fail_uneven(const fs::path& place, const std::vector<DicomImage>& stack) {
  const double median = median_gap(stack);
  std::size_t worst = 1;
  const auto off = [&](std::size_t i) {
    return std::abs(stack[i].along - stack[i - 1].along - median);
  };
  for (std::size_t i = 1; i < stack.size(); ++i) {
    if (off(i) > off(worst)) worst = i;
  }
  const double gap = stack[worst].along - stack[worst - 1].along;
  const double missing = std::round(gap / median) - 1;
  const auto name_of = [](const DicomImage& image) {
    return "'" + image.file.filename().string() + "'" +
           (image.frames > 1 ? " frame " + std::to_string(image.frame + 1) : "");
  };
  fail_reading(place,
               "its slices are not evenly spaced: the distance between " +
                   name_of(stack[worst - 1]) + " and " + name_of(stack[worst]) + " is " +
                   rounded_text(gap) + " mm, that between most slices " + rounded_text(median) +
                   " mm" +
                   (missing >= 1 ? "; " + rounded_text(missing) + " seem to be missing" : ""),
               "Get all slices, or interpolate them to an even spacing with --resample");
}

// Throws if the number of samples along an axis of the grid exceeds the limit.
void check_count(const fs::path& place, double count, const char* what) {
  if (count <= kMaxSlices) return;
  fail_reading(place,
               "its slices are so far apart that an even grid through them would have " +
                   rounded_text(count) + " " + what,
               "Remove the slices that are far from the others");
}

// Returns an even grid along the axes of the first slice, to which all slices are resampled.
DicomGrid even_grid(const fs::path& place, const std::vector<DicomImage>& stack, bool is_tilted) {
  const DicomImage& first = stack.front();
  const Vec3 normal = cross(first.row, first.column);
  const double height = stack.back().along - first.along;
  const double intervals = std::max(1.0, std::round(height / median_gap(stack)));
  const double step = height / intervals;
  check_count(place, intervals + 1, "slices");
  SlicePlaces places{.size = first.size,
                     .at = {},
                     .shift = {},
                     .dims = {0, 0, static_cast<std::int64_t>(intervals) + 1}};
  for (const DicomImage& image : stack) {
    const Vec3 way = difference(image.position, first.position);
    std::array<double, 2> shift{};
    // Without a tilt, shifts are rounding errors; interpolation would only blur the slices.
    if (is_tilted)
      shift = {dot(way, first.row) / first.spacing[0], dot(way, first.column) / first.spacing[1]};
    places.at.push_back((image.along - first.along) / step);
    places.shift.push_back(shift);
  }
  DicomGrid grid{.steps = {scaled(first.row, first.spacing[0]),
                           scaled(first.column, first.spacing[1]), scaled(normal, step)},
                 .origin = first.position};
  const std::array<double, 2> low = places.fit_grid();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    check_count(place, static_cast<double>(places.dims[axis]), axis == 0 ? "columns" : "rows");
    grid.origin = moved(grid.origin, low[axis], grid.steps[axis]);
  }
  grid.resampled = std::move(places);
  return grid;
}

}  // namespace

DicomGrid dicom_grid(const fs::path& place, const std::vector<DicomImage>& stack,
                     const VolumeChoice& choice, std::vector<std::string>& notices) {
  const DicomImage& first = stack.front();
  DicomGrid grid{
      .steps = {scaled(first.row, first.spacing[0]), scaled(first.column, first.spacing[1]),
                scaled(cross(first.row, first.column), first.spacing[2])},
      .origin = first.position};
  if (stack.size() == 1) return grid;
  const Vec3 step = scaled(difference(stack.back().position, first.position),
                           1 / static_cast<double>(stack.size() - 1));
  grid.steps[2] = step;
  double largest = 0;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const Vec3 expected = scaled(step, static_cast<double>(i));
    const Vec3 found = difference(stack[i].position, first.position);
    largest = std::max(largest, length(difference(found, expected)));
  }
  const double step_length = length(step);
  const bool is_even = largest <= kOnGrid * step_length || choice.given.spacing;
  const bool is_tilted = std::abs(dot(step, first.row)) > kTilt * step_length ||
                         std::abs(dot(step, first.column)) > kTilt * step_length;
  if (is_even && !is_tilted) {
    if (largest > kReportedDeviation * step_length && !choice.given.spacing) {
      notices.push_back("'" + place.string() + "': its slices are up to " + rounded_text(largest) +
                        " mm off an even grid with steps of " + rounded_text(step_length) +
                        " mm; the even grid is used.");
    }
    return grid;
  }
  if (!choice.resample) {
    if (!is_even) fail_uneven(place, stack);
    fail_reading(place,
                 "its slices are shifted against each other, as by a tilted gantry: the step from "
                 "slice to slice is not perpendicular to them",
                 "Interpolate them onto a rectangular grid with --resample");
  }
  grid = even_grid(place, stack, is_tilted);
  const std::array<std::int64_t, 3>& dims = grid.resampled->dims;
  const std::string shifted = "shifted against each other (a tilted gantry)";
  const std::string what = is_even     ? shifted
                           : is_tilted ? "not evenly spaced, and " + shifted
                                       : "not evenly spaced";
  notices.push_back("'" + place.string() + "': its " + std::to_string(stack.size()) +
                    " slices are " + what + "; --resample makes them " + std::to_string(dims[2]) +
                    " slices of " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) +
                    " samples, " + rounded_text(length(grid.steps[2])) + " mm apart.");
  return grid;
}

}  // namespace multitetra
