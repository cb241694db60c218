#include "server/volume/labels/border_samples.hpp"

#include <algorithm>
#include <cmath>

#include "server/volume/labels/label_smoothing.hpp"

namespace multitetra {
namespace {

// Beside a wall, the smoothed indicator differs by 3 / 16 from one half.
constexpr double kSmoothedScale = kWallMagnitude / (3.0 / 16 * kFieldSteps);
// Smoothing reaches 2.5 samples: there, both measures are equal.
constexpr double kMagnitudePerSample = kWallMagnitude / 2.5;
// From the middle of a cube of 5 x 5 x 5 samples to its faces.
constexpr std::int32_t kCubeReach = 2;

}  // namespace

BorderSearch::BorderSearch(const LabelDims& dims, const ReadLabels& read)
    : dims_(dims), read_(read) {
  const std::size_t samples = place(0, dims[1]);
  for (Slice& slice : slices_) {
    slice.labels.resize(samples);
    slice.is_border.resize(samples);
    slice.is_square.resize(samples);
    slice.is_cube.resize(samples);
  }
}

std::uint32_t BorderSearch::next(std::span<BorderSample> into) {
  const std::int32_t z = next_++;
  while (loaded_ <= std::min(z + kTerraceReach, dims_[2] - 1)) load(loaded_++);
  std::uint32_t count = 0;
  for (std::int32_t y = 0; y < dims_[1]; ++y) {
    for (std::int32_t x = 0; x < dims_[0]; ++x) {
      const std::size_t i = place(x, y);
      into[i] = {};
      if (slice(z).is_border[i] == 0) continue;
      ++count;
      const std::int32_t label = slice(z).labels[i];
      if (label == kBeyondMap) {
        into[i] = {.magnitude = kWallMagnitude, .is_thick = 1};
        continue;
      }
      const int magnitude =
          std::max(smoothed_magnitude({x, y, z}, label), terrace_magnitude({x, y, z}, label));
      into[i].magnitude =
          static_cast<std::uint8_t>(std::clamp(magnitude, kMinMagnitude, kMaxMagnitude) & 0x7F);
      into[i].is_thick = is_thick({x, y, z}, label) ? 1 : 0;
    }
  }
  return count;
}

std::vector<BorderSearch::PlaneStep> BorderSearch::plane_steps() {
  std::vector<PlaneStep> steps;
  for (std::int32_t v = -kTerraceReach; v <= kTerraceReach; ++v) {
    for (std::int32_t u = -kTerraceReach; u <= kTerraceReach; ++u) {
      const std::int32_t squared = u * u + v * v;
      if (squared == 0 || squared > kTerraceReach * kTerraceReach) continue;
      steps.push_back({u, v, std::sqrt(static_cast<double>(squared))});
    }
  }
  std::stable_sort(steps.begin(), steps.end(),
                   [](const PlaneStep& a, const PlaneStep& b) { return a.length < b.length; });
  return steps;
}

std::size_t BorderSearch::place(std::int32_t x, std::int32_t y) const {
  return static_cast<std::size_t>(x) +
         static_cast<std::size_t>(y) * static_cast<std::size_t>(dims_[0]);
}

// Loads slice z, and marks what the slices up to it decide.
void BorderSearch::load(std::int32_t z) {
  Slice& loaded = slice(z);
  read_(z, loaded.labels);
  std::fill(loaded.is_border.begin(), loaded.is_border.end(), std::uint8_t{0});
  if (z > 0) mark_borders(slice(z - 1), loaded);
  find_squares(loaded);
  std::fill(loaded.is_cube.begin(), loaded.is_cube.end(), std::uint8_t{0});
  if (z >= 2 * kCubeReach) find_cubes(z - kCubeReach);
}

// Marks the corners of cells between two slices that have more than one label.
void BorderSearch::mark_borders(Slice& lower, Slice& upper) const {
  const auto width = static_cast<std::size_t>(dims_[0]);
  const std::vector<std::int32_t>& below = lower.labels;
  const std::vector<std::int32_t>& above = upper.labels;
  for (std::size_t row = 0; row + width < below.size(); row += width) {
    for (std::size_t x = row; x + 1 < row + width; ++x) {
      const std::int32_t label = below[x];
      const std::int32_t difference = (below[x + 1] ^ label) | (below[x + width] ^ label) |
                                      (below[x + width + 1] ^ label) | (above[x] ^ label) |
                                      (above[x + 1] ^ label) | (above[x + width] ^ label) |
                                      (above[x + width + 1] ^ label);
      if (difference == 0) continue;
      for (std::vector<std::uint8_t>* const marks : {&lower.is_border, &upper.is_border}) {
        (*marks)[x] = (*marks)[x + 1] = (*marks)[x + width] = (*marks)[x + width + 1] = 1;
      }
    }
  }
}

// Marks the middles of squares of one label.
void BorderSearch::find_squares(Slice& slice) const {
  const auto width = static_cast<std::size_t>(dims_[0]);
  constexpr std::size_t kReach = kCubeReach;
  const std::vector<std::int32_t>& labels = slice.labels;
  std::fill(slice.is_square.begin(), slice.is_square.end(), std::uint8_t{0});
  std::size_t along_x = 0;                  // Number of equal labels up to here.
  std::vector<std::size_t> along_y(width);  // Number of rows of them up to here.
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::size_t x = i % width;
    along_x = x > 0 && labels[i] == labels[i - 1] ? along_x + 1 : 1;
    const bool goes_on = i >= width && labels[i] == labels[i - width];
    along_y[x] = along_x <= 2 * kReach ? 0 : goes_on ? along_y[x] + 1 : 1;
    if (along_y[x] > 2 * kReach) slice.is_square[i - kReach * (width + 1)] = 1;
  }
}

// Marks the middles of cubes in slice z, which has kCubeReach slices on either side.
void BorderSearch::find_cubes(std::int32_t z) {
  Slice& middle = slice(z);
  middle.is_cube = middle.is_square;
  for (std::int32_t k = -kCubeReach; k <= kCubeReach; ++k) {
    const Slice& other = slice(z + k);
    for (std::size_t i = 0; i < middle.is_cube.size(); ++i) {
      if (other.is_square[i] == 0 || other.labels[i] != middle.labels[i]) middle.is_cube[i] = 0;
    }
  }
}

int BorderSearch::smoothed_magnitude(const LabelDims& at, std::int32_t label) {
  const auto& [x, y, z] = at;
  std::uint32_t sum = 0;
  for (std::int32_t k = -kSmoothingReach; k <= kSmoothingReach; ++k) {
    const std::vector<std::int32_t>& labels =
        slice(static_cast<std::int32_t>(clamped_step(z, k, dims_[2]))).labels;
    for (std::int32_t j = -kSmoothingReach; j <= kSmoothingReach; ++j) {
      const std::size_t row = clamped_step(y, j, dims_[1]) * static_cast<std::size_t>(dims_[0]);
      for (std::int32_t i = -kSmoothingReach; i <= kSmoothingReach; ++i) {
        if (labels[row + clamped_step(x, i, dims_[0])] != label) continue;
        sum += smoothing_weight(i) * smoothing_weight(j) * smoothing_weight(k);
      }
    }
  }
  return static_cast<int>(kSmoothedScale * (smoothed_steps(sum) - kFieldSteps / 2));
}

int BorderSearch::terrace_magnitude(const LabelDims& at, std::int32_t label) {
  double greatest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    double distance = kTerraceReach + 1;
    for (const PlaneStep& step : steps_) {
      LabelDims to = at;
      to[u] += step.u;
      to[v] += step.v;
      if (to[u] < 0 || to[u] >= dims_[u] || to[v] < 0 || to[v] >= dims_[v]) continue;
      if (slice(to[2]).labels[place(to[0], to[1])] == label) continue;
      distance = step.length - 0.5;
      break;
    }
    greatest = std::max(greatest, distance);
  }
  return static_cast<int>(kMagnitudePerSample * greatest);
}

bool BorderSearch::is_thick(const LabelDims& at, std::int32_t label) {
  LabelDims first{};
  LabelDims last{};
  for (std::size_t i = 0; i < 3; ++i) {
    first[i] = std::max(at[i] - kCubeReach - 1, 0);
    last[i] = std::min(at[i] + kCubeReach + 1, dims_[i] - 1);
  }
  for (std::int32_t z = first[2]; z <= last[2]; ++z) {
    const Slice& other = slice(z);
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      for (std::int32_t x = first[0]; x <= last[0]; ++x) {
        const std::size_t i = place(x, y);
        if (other.is_cube[i] != 0 && other.labels[i] == label) return true;
      }
    }
  }
  return false;
}

}  // namespace multitetra
