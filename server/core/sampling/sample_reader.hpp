// Random access to samples in the bricks of a prepared dataset, for planes and surfaces, which
// touch few of them.
//
// Two readers have the same interface: one for all samples, and one for every eighth along each
// axis, which are stored together and need no bricks. Places are sample indices for both.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "common/base/vec3.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// The value of places without a field.
inline constexpr float kNoField = std::numeric_limits<float>::quiet_NaN();

// A place this near to a plane of samples is treated as on it, so that converting a sample's
// position to world coordinates and back selects that sample.
inline constexpr double kSnapDistance = 1e-6;

[[nodiscard]] inline double snapped_to_sample(double coordinate) {
  const double nearest = std::nearbyint(coordinate);
  return std::abs(coordinate - nearest) <= kSnapDistance ? nearest : coordinate;
}

// Returns whether the place lies in the data's closed box.
[[nodiscard]] inline bool is_in_data(const Vec3& index, const DatasetInfo& info) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = snapped_to_sample(index[axis]);
    if (!(at >= 0 && at <= info.dims[axis] - 1)) return false;
  }
  return true;
}

// Reads all samples and caches the last bricks used. Not thread-safe. The volume must outlive it.
// Rethrows exceptions from reading a brick.
template <typename Sample>
class BrickReader {
 public:
  explicit BrickReader(const PreparedVolume& volume)
      : source_(*volume.samples), layout_(volume.info.dims) {
    known_.fill({kNone, {}});
  }

  // Returns the place in units of this reader's samples. Requires a place in the data.
  [[nodiscard]] Vec3 unit_place(const Vec3& index) const {
    return {along(0, index[0]), along(1, index[1]), along(2, index[2])};
  }
  // One of its coordinates.
  [[nodiscard]] static double along(std::size_t, double index) { return snapped_to_sample(index); }
  // Requires 0 <= p < dims.
  [[nodiscard]] float at(GridPoint p) {
    const GridCounts brick = {p.x / kSide, p.y / kSide, p.z / kSide};
    const GridCounts extent = layout_.extent(brick);
    const Sample* const samples = brick_at(layout_.index(brick));
    return static_cast<float>(
        samples[p.x % kSide + extent[0] * (p.y % kSide + extent[1] * (p.z % kSide))]);
  }
  // Fills a row with the samples at p, p + step along x, and so on. Requires all in the data.
  void fill_row(GridPoint p, std::int32_t step, std::span<float> values) {
    for (std::size_t i = 0; i < values.size();) {
      const GridCounts brick = {p.x / kSide, p.y / kSide, p.z / kSide};
      const GridCounts extent = layout_.extent(brick);
      const Sample* const row =
          brick_at(layout_.index(brick)) + extent[0] * (p.y % kSide + extent[1] * (p.z % kSide));
      for (std::int32_t x = p.x - kSide * brick[0]; x < kSide && i < values.size(); x += step) {
        values[i++] = static_cast<float>(row[x]);
        p.x += step;
      }
    }
  }

 private:
  static constexpr std::int32_t kSide = BrickLayout::kSampleSide;
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  const Sample* brick_at(std::size_t index) {
    Known& known = known_[index % known_.size()];
    if (known.index != index) {
      known = {index, source_.brick(index)};
    }
    return reinterpret_cast<const Sample*>(known.bytes.data());
  }

  struct Known {
    std::size_t index = kNone;
    RetainedBytes bytes;
  };
  const BrickSource& source_;
  BrickLayout layout_;
  std::array<Known, 61> known_;
};

// Returns whether there are samples at multiples of 8 for an overview of the volume.
[[nodiscard]] inline bool has_coarse_samples(const DatasetInfo& info) {
  const GridPoint extent = coarse_extent(info).extent;
  return std::min({extent.x, extent.y, extent.z}) > 0;
}

// Reads every eighth sample along each axis: those at multiples of kSpectrumSpacing in the grid.
// Beyond the outermost of these, uses the outermost. The volume must outlive it. Requires
// has_coarse_samples().
template <typename Sample>
class CoarseReader {
 public:
  explicit CoarseReader(const PreparedVolume& volume)
      : samples_(volume.coarse.bytes()),
        extent_(coarse_extent(volume.info)),
        margin_(volume.info.margin) {
    assert(has_coarse_samples(volume.info));
  }

  [[nodiscard]] Vec3 unit_place(const Vec3& index) const {
    return {along(0, index[0]), along(1, index[1]), along(2, index[2])};
  }
  [[nodiscard]] double along(std::size_t axis, double index) const {
    const auto i = static_cast<int>(axis);
    const double unit = (snapped_to_sample(index) + margin_) / kSpectrumSpacing - extent_.low[i];
    return std::clamp(unit, 0.0, static_cast<double>(extent_.extent[i] - 1));
  }
  [[nodiscard]] float at(GridPoint p) const {
    Sample sample;
    std::memcpy(&sample, samples_.data() + sizeof(Sample) * extent_.index(p + extent_.low),
                sizeof(Sample));
    return static_cast<float>(sample);
  }

 private:
  std::span<const std::byte> samples_;
  LevelExtent extent_;
  std::int32_t margin_;
};

[[nodiscard]] inline std::int32_t nearest_sample(double unit_coordinate) {
  return static_cast<std::int32_t>(std::floor(unit_coordinate + 0.5));
}

// Returns the sample nearest to a place in units of the reader.
template <typename Reader>
[[nodiscard]] float nearest_value(Reader& reader, const Vec3& unit_place) {
  return reader.at({nearest_sample(unit_place[0]), nearest_sample(unit_place[1]),
                    nearest_sample(unit_place[2])});
}

// Returns the trilinear value at a place in units of the reader. Ignores samples with weight 0, so
// a place at a sample gives that sample; NaN if a sample with nonzero weight is void.
template <typename Reader>
[[nodiscard]] double linear_value(Reader& reader, const Vec3& unit_place) {
  std::array<std::int32_t, 3> low{};
  std::array<double, 3> beyond{};
  std::array<int, 3> corners{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double floor = std::floor(unit_place[axis]);
    low[axis] = static_cast<std::int32_t>(floor);
    beyond[axis] = unit_place[axis] - floor;
    corners[axis] = beyond[axis] > 0 ? 2 : 1;
  }
  const auto weight = [&](std::size_t axis, int corner) {
    return corner == 0 ? 1 - beyond[axis] : beyond[axis];
  };
  double value = 0;
  for (int z = 0; z < corners[2]; ++z) {
    for (int y = 0; y < corners[1]; ++y) {
      const double weight_yz = weight(1, y) * weight(2, z);
      for (int x = 0; x < corners[0]; ++x) {
        const float sample = reader.at({low[0] + x, low[1] + y, low[2] + z});
        value += weight(0, x) * weight_yz * static_cast<double>(sample);
      }
    }
  }
  return value;
}

// Returns the trilinear value at a place in sample indices, or kNoField.
template <typename Reader>
[[nodiscard]] double value_at(Reader& reader, const DatasetInfo& info, const Vec3& index) {
  if (!is_in_data(index, info)) return static_cast<double>(kNoField);
  return linear_value(reader, reader.unit_place(index));
}

}  // namespace multitetra
