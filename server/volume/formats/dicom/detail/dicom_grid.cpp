#include "server/volume/formats/dicom/detail/dicom_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
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

// Returns the number of samples along an axis of the grid; throws if it exceeds the limit.
std::int64_t grid_count(const fs::path& place, double count, const char* what) {
  if (count <= kMaxSlices) return static_cast<std::int64_t>(count);
  fail_reading(place,
               "its slices are so far apart that an even grid through them would have " +
                   rounded_text(count) + " " + what,
               "Remove the slices that are far from the others");
}

// Returns an even grid along the axes of the first slice, to which all slices are interpolated.
DicomGrid even_grid(const fs::path& place, const std::vector<DicomImage>& stack, bool is_tilted) {
  const DicomImage& first = stack.front();
  const Vec3 normal = cross(first.row, first.column);
  const double height = stack.back().along - first.along;
  const double intervals = std::max(1.0, std::round(height / median_gap(stack)));
  const double step = height / intervals;
  SlicePlaces places{.at = {}, .shift = {}, .size = first.size};
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  for (const DicomImage& image : stack) {
    const Vec3 way = difference(image.position, first.position);
    std::array<double, 2> shift{};
    // Without a tilt, shifts are rounding errors; interpolation would only blur the slices.
    if (is_tilted)
      shift = {dot(way, first.row) / first.spacing[0], dot(way, first.column) / first.spacing[1]};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (std::abs(shift[axis] - std::round(shift[axis])) < kReportedDeviation)
        shift[axis] = std::round(shift[axis]);
      low[axis] = std::min(low[axis], std::floor(shift[axis]));
      high[axis] = std::max(high[axis], std::ceil(shift[axis]));
    }
    places.at.push_back((image.along - first.along) / step);
    places.shift.push_back(shift);
  }
  DicomGrid grid{.steps = {scaled(first.row, first.spacing[0]),
                           scaled(first.column, first.spacing[1]), scaled(normal, step)},
                 .origin = first.position};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (auto& shift : places.shift) shift[axis] -= low[axis];
    grid.dims[axis] =
        grid_count(place, static_cast<double>(first.size[axis]) + high[axis] - low[axis],
                   axis == 0 ? "columns" : "rows");
    for (std::size_t row = 0; row < 3; ++row) grid.origin[row] += grid.steps[axis][row] * low[axis];
  }
  grid.dims[2] = grid_count(place, intervals + 1, "slices");
  grid.resampled = std::move(places);
  return grid;
}

class ResampledSlices : public StoredSlices {
 public:
  ResampledSlices(std::unique_ptr<StoredSlices> slices, const DicomGrid& grid,
                  std::int64_t components)
      : slices_(std::move(slices)),
        dims_(grid.dims),
        places_(*grid.resampled),
        components_(static_cast<std::size_t>(components)) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const auto numbers = static_cast<std::size_t>(dims_[0] * dims_[1]) * components_;
    slice_.resize(numbers);
    for (std::size_t i = 0; i < count; ++i) {
      interpolate(static_cast<double>(first + i));
      const auto bytes = std::as_bytes(std::span(slice_));
      std::copy(bytes.begin(), bytes.end(), into + i * bytes.size());
    }
  }

 private:
  struct LoadedSlice {
    std::size_t index = ~std::size_t{0};
    std::vector<float> numbers = {};
  };

  // Returns slice `index` of the files; keeps the previous one loaded.
  const std::vector<float>& loaded(std::size_t index) {
    LoadedSlice& slice = loaded_[index % 2];
    if (slice.index == index) return slice.numbers;
    slice.index = ~std::size_t{0};
    slice.numbers.resize(static_cast<std::size_t>(places_.size[0] * places_.size[1]) * components_);
    slices_->read(index, 1, std::as_writable_bytes(std::span(slice.numbers)).data());
    slice.index = index;
    return slice.numbers;
  }

  // Fills slice_ for a position along the normal.
  void interpolate(double at) {
    const std::vector<double>& there = places_.at;
    const auto behind = std::upper_bound(there.begin(), there.end(), at);
    const auto above = std::min(static_cast<std::size_t>(behind - there.begin()), there.size() - 1);
    const std::size_t below = above == 0 ? 0 : above - 1;
    const double gap = there[above] - there[below];
    double weight = gap > 0 ? std::clamp((at - there[below]) / gap, 0.0, 1.0) : 0;
    if (weight < 1e-9) weight = 0;
    if (weight > 1 - 1e-9) weight = 1;
    if (weight < 1) put(below, 1 - weight, false);
    if (weight > 0) put(above, weight, weight < 1);
  }

  // Adds a weighted slice to slice_, or assigns it.
  void put(std::size_t index, double weight, bool adds) {
    const std::vector<float>& from = loaded(index);
    const std::array<double, 2> shift = places_.shift[index];
    std::size_t out = 0;
    for (std::int64_t y = 0; y < dims_[1]; ++y) {
      for (std::int64_t x = 0; x < dims_[0]; ++x) {
        const double column = static_cast<double>(x) - shift[0];
        const double row = static_cast<double>(y) - shift[1];
        for (std::size_t component = 0; component < components_; ++component, ++out) {
          const auto number = static_cast<float>(weight * value_at(from, column, row, component));
          slice_[out] = adds ? slice_[out] + number : number;
        }
      }
    }
  }

  [[nodiscard]] double value_at(const std::vector<float>& from, double column, double row,
                                std::size_t component) const {
    const double x0 = std::floor(column);
    const double y0 = std::floor(row);
    const double fx = column - x0;
    const double fy = row - y0;
    if (column < 0 || row < 0 || column > static_cast<double>(places_.size[0] - 1) ||
        row > static_cast<double>(places_.size[1] - 1)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const auto number = [&](double x, double y) {
      const auto sample = static_cast<std::size_t>(y) * static_cast<std::size_t>(places_.size[0]) +
                          static_cast<std::size_t>(x);
      return static_cast<double>(from[sample * components_ + component]);
    };
    double value = number(x0, y0) * (1 - fx) * (1 - fy);
    if (fx > 0) value += number(x0 + 1, y0) * fx * (1 - fy);
    if (fy > 0) value += number(x0, y0 + 1) * (1 - fx) * fy;
    if (fx > 0 && fy > 0) value += number(x0 + 1, y0 + 1) * fx * fy;
    return value;
  }

  std::unique_ptr<StoredSlices> slices_;
  std::array<std::int64_t, 3> dims_;
  SlicePlaces places_;
  std::size_t components_;
  std::array<LoadedSlice, 2> loaded_;
  std::vector<float> slice_;
};

}  // namespace

DicomGrid dicom_grid(const fs::path& place, const std::vector<DicomImage>& stack, bool resample,
                     std::vector<std::string>& notices) {
  const DicomImage& first = stack.front();
  DicomGrid grid{
      .dims = {first.size[0], first.size[1], static_cast<std::int64_t>(stack.size())},
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
  const bool is_even = largest <= kOnGrid * step_length;
  const bool is_tilted = std::abs(dot(step, first.row)) > kTilt * step_length ||
                         std::abs(dot(step, first.column)) > kTilt * step_length;
  if (is_even && !is_tilted) {
    if (largest > kReportedDeviation * step_length) {
      notices.push_back("'" + place.string() + "': its slices are up to " + rounded_text(largest) +
                        " mm off an even grid with steps of " + rounded_text(step_length) +
                        " mm; the even grid is used.");
    }
    return grid;
  }
  if (!resample) {
    if (!is_even) fail_uneven(place, stack);
    fail_reading(place,
                 "its slices are shifted against each other, as by a tilted gantry: the step from "
                 "slice to slice is not perpendicular to them",
                 "Interpolate them onto a rectangular grid with --resample");
  }
  grid = even_grid(place, stack, is_tilted);
  notices.push_back(
      "'" + place.string() + "': its " + std::to_string(stack.size()) + " slices " +
      (is_even ? "" : "are not evenly spaced; they ") +
      (is_tilted ? (is_even ? "are shifted against each other (a tilted gantry); they "
                            : "and their tilt ")
                 : "") +
      "are interpolated to " + std::to_string(grid.dims[2]) + " slices of " +
      std::to_string(grid.dims[0]) + " x " + std::to_string(grid.dims[1]) + " samples, " +
      rounded_text(length(grid.steps[2])) + " mm apart; gaps between them are void.");
  return grid;
}

std::unique_ptr<StoredSlices> resampled_slices(std::unique_ptr<StoredSlices> slices,
                                               const DicomGrid& grid, std::int64_t components) {
  return std::make_unique<ResampledSlices>(std::move(slices), grid, components);
}

}  // namespace multitetra
