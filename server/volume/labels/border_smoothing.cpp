#include "server/volume/labels/border_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace multitetra {
namespace {

// Passes diverge above 0.5; four of 0.45 are as smooth as many.
constexpr float kStrength = 0.45F;
// The multiple of the second differences that restores the volume of balls.
constexpr float kShrinkage = 1.5F;

struct Direction {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  float weight = 0;
};

// Returns one of each two opposite directions to the 26 neighbors; nearer ones weigh more.
constexpr std::array<Direction, 13> directions() {
  std::array<Direction, 13> all{};
  std::size_t count = 0;
  for (std::int32_t number = 14; number < 27; ++number) {
    const std::int32_t x = number % 3 - 1;
    const std::int32_t y = number / 3 % 3 - 1;
    const std::int32_t z = number / 9 - 1;
    const int steps = (x != 0 ? 1 : 0) + (y != 0 ? 1 : 0) + (z != 0 ? 1 : 0);
    all[count++] = {x, y, z, static_cast<float>(8 >> steps)};
  }
  return all;
}

}  // namespace

BorderSmoothing::BorderSmoothing(const LabelDims& dims, const ReadLabels& read_labels,
                                 const ReadSamples& read_samples)
    : dims_(dims), read_labels_(read_labels), read_samples_(read_samples) {
  const std::size_t count = static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
  for (Slice& slice : window_) {
    slice.labels.resize(count);
    slice.samples.resize(count);
    slice.magnitudes.resize(count);
    slice.curvatures.resize(count);
  }
}

void BorderSmoothing::smooth(const StoreSamples& store, bool is_first) {
  std::vector<BorderSample> smoothed(window_[0].samples.size());
  // A slice's curvatures need both neighbors, and so do its new magnitudes.
  for (std::int32_t z = 0; z < dims_[2] + 2; ++z) {
    if (z < dims_[2]) load(z);
    if (z >= 1 && z - 1 < dims_[2]) find_curvatures(z - 1);
    if (z < 2) continue;
    write(z - 2, is_first, smoothed);
    store(z - 2, smoothed);
  }
}

void BorderSmoothing::load(std::int32_t z) {
  Slice& loaded = slice(z);
  read_samples_(z, loaded.samples);
  bool has_any = false;
  for (std::size_t i = 0; i < loaded.samples.size(); ++i) {
    loaded.magnitudes[i] = static_cast<float>(loaded.samples[i].magnitude);
    has_any = has_any || loaded.samples[i].magnitude != 0;
  }
  if (has_any) read_labels_(z, loaded.labels);
}

void BorderSmoothing::find_curvatures(std::int32_t z) {
  Slice& found = slice(z);
  std::size_t i = 0;
  for (std::int32_t y = 0; y < dims_[1]; ++y) {
    for (std::int32_t x = 0; x < dims_[0]; ++x, ++i) {
      if (found.magnitudes[i] == 0) continue;
      found.curvatures[i] = second_difference({x, y, z}, &Slice::magnitudes);
    }
  }
}

void BorderSmoothing::write(std::int32_t z, bool is_first, std::span<BorderSample> into) {
  const Slice& from = slice(z);
  std::size_t i = 0;
  for (std::int32_t y = 0; y < dims_[1]; ++y) {
    for (std::int32_t x = 0; x < dims_[0]; ++x, ++i) {
      into[i] = from.samples[i];
      if (from.magnitudes[i] == 0 || from.labels[i] == kBeyondMap) continue;
      if (touches_thin_part({x, y, z})) {
        if (is_first) into[i].magnitude = kWallMagnitude;
        continue;
      }
      const float change = kStrength * second_difference({x, y, z}, &Slice::curvatures) +
                           (is_first ? kShrinkage * from.curvatures[i] : 0.0F);
      const auto magnitude = static_cast<int>(std::floor(from.magnitudes[i] - change + 0.5F));
      into[i].magnitude =
          static_cast<std::uint8_t>(std::clamp(magnitude, kMinMagnitude, kMaxMagnitude) & 0x7F);
    }
  }
}

bool BorderSmoothing::touches_thin_part(const LabelDims& at) {
  const auto& [x, y, z] = at;
  for (std::int32_t w = std::max(z - 1, 0); w <= std::min(z + 1, dims_[2] - 1); ++w) {
    const Slice& other = slice(w);
    for (std::int32_t v = std::max(y - 1, 0); v <= std::min(y + 1, dims_[1] - 1); ++v) {
      for (std::int32_t u = std::max(x - 1, 0); u <= std::min(x + 1, dims_[0] - 1); ++u) {
        const auto i = static_cast<std::size_t>(u) +
                       static_cast<std::size_t>(v) * static_cast<std::size_t>(dims_[0]);
        if (other.magnitudes[i] != 0 && other.samples[i].is_thick == 0) return true;
      }
    }
  }
  return false;
}

float BorderSmoothing::second_difference(const LabelDims& at, std::vector<float> Slice::*values) {
  static constexpr std::array<Direction, 13> kDirections = directions();
  const auto& [x, y, z] = at;
  const std::ptrdiff_t width = dims_[0];
  const std::ptrdiff_t i = x + y * width;
  const Slice& own = slice(z);
  const auto label = own.labels[static_cast<std::size_t>(i)];
  const float twice = 2 * (own.*values)[static_cast<std::size_t>(i)];
  float sum = 0;
  float weight = 0;
  for (const Direction& to : kDirections) {
    const bool is_inside = x >= std::abs(to.x) && x + std::abs(to.x) < dims_[0] &&
                           y >= std::abs(to.y) && y + std::abs(to.y) < dims_[1] && z >= to.z &&
                           z + to.z < dims_[2];
    if (!is_inside) continue;
    const Slice& above = slice(z + to.z);
    const Slice& below = slice(z - to.z);
    const std::ptrdiff_t step = to.x + to.y * width;
    const auto ahead = static_cast<std::size_t>(i + step);
    const auto behind = static_cast<std::size_t>(i - step);
    if (above.magnitudes[ahead] == 0 || below.magnitudes[behind] == 0) continue;
    const float next = (above.*values)[ahead];
    const float previous = (below.*values)[behind];
    sum += to.weight * ((above.labels[ahead] == label ? next : -next) +
                        (below.labels[behind] == label ? previous : -previous) - twice);
    weight += 2 * to.weight;
  }
  return weight > 0 ? sum / weight : 0;
}

}  // namespace multitetra
