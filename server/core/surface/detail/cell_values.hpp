// The values around the cells of vertices, from bricks of samples or from the coarse samples.
// Outside the grid they are void; between the data and the grid's end, the value outside.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/core/surface/detail/cell_gradient.hpp"

namespace multitetra {

// The position of the data in the grid, in units.
struct DataSurroundings {
  std::int32_t last = 0;  // Largest coordinate of the grid.
  float outside = std::numeric_limits<float>::quiet_NaN();

  [[nodiscard]] float beyond_data(GridPoint p) const {
    const bool in_grid = std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) <= last;
    return in_grid ? outside : std::numeric_limits<float>::quiet_NaN();
  }
};

// Values at all grid points, from the bricks of samples around a box. The unit is a grid step.
template <typename Sample>
class BrickValues {
 public:
  // Serves cells with lowest corners from `low` to `high`.
  BrickValues(const PreparedVolume& volume, GridPoint low, GridPoint high)
      : source_(*volume.samples),
        layout_(volume.info.dims),
        first_(first_sample(volume.info)),
        surroundings_{.last = 1 << volume.info.grid_exponent,
                      .outside = outside_value(volume.info)} {
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const std::int32_t last_brick = layout_.counts()[i] - 1;
      first_brick_[i] = std::clamp((low[axis] - 1 - first_[axis]) / kSide, 0, last_brick);
      bricks_[i] =
          std::clamp((high[axis] + 2 - first_[axis]) / kSide, 0, last_brick) + 1 - first_brick_[i];
    }
    read_.resize(static_cast<std::size_t>(bricks_[0]) * static_cast<std::size_t>(bricks_[1]) *
                 static_cast<std::size_t>(bricks_[2]));
  }

  void fill(const PlaceInCell& place, CellNeighbourhood& values) {
    const GridPoint low = place.cell - first_ - GridPoint{1, 1, 1};  // In sample indices.
    const GridPoint extent = {place.corners[0] + 2, place.corners[1] + 2, place.corners[2] + 2};
    if (is_in_one_brick(low, extent)) {
      const Brick& brick = brick_of(low);
      const Sample* const from = brick.at(low);
      values.fill(place.corners, [&](int x, int y, int z) {
        return static_cast<float>(from[x + brick.row * y + brick.slice * z]);
      });
    } else {
      values.fill(place.corners, [&](int x, int y, int z) {
        return value(low + GridPoint{x, y, z});
      });
    }
  }

 private:
  static constexpr std::int32_t kSide = BrickLayout::kSampleSide;

  struct Brick {
    RetainedBytes bytes;
    const Sample* samples = nullptr;
    std::int32_t row = 0;
    std::int32_t slice = 0;

    [[nodiscard]] const Sample* at(GridPoint p) const {
      return samples + (p.x % kSide + row * (p.y % kSide) + slice * (p.z % kSide));
    }
  };

  [[nodiscard]] bool is_in_one_brick(GridPoint low, GridPoint extent) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t end = low[axis] + extent[axis];
      if (low[axis] < 0 || end > layout_.dims()[static_cast<std::size_t>(axis)] ||
          low[axis] / kSide != (end - 1) / kSide) {
        return false;
      }
    }
    return true;
  }

  // Requires a sample of the data.
  const Brick& brick_of(GridPoint p) {
    const GridCounts at = {p.x / kSide, p.y / kSide, p.z / kSide};
    Brick& brick = read_[static_cast<std::size_t>(
        (at[0] - first_brick_[0]) +
        std::ptrdiff_t{bricks_[0]} *
            ((at[1] - first_brick_[1]) + std::ptrdiff_t{bricks_[1]} * (at[2] - first_brick_[2])))];
    if (brick.samples == nullptr) {
      const GridCounts extent = layout_.extent(at);
      brick = {.bytes = source_.brick(layout_.index(at)),
               .row = extent[0],
               .slice = extent[0] * extent[1]};
      brick.samples = reinterpret_cast<const Sample*>(brick.bytes.data());
    }
    return brick;
  }

  float value(GridPoint p) {
    const GridCounts& dims = layout_.dims();
    const bool in_data =
        std::min({p.x, p.y, p.z}) >= 0 && p.x < dims[0] && p.y < dims[1] && p.z < dims[2];
    return in_data ? static_cast<float>(*brick_of(p).at(p)) : surroundings_.beyond_data(p + first_);
  }

  const BrickSource& source_;
  BrickLayout layout_;
  GridPoint first_;
  DataSurroundings surroundings_;
  GridCounts first_brick_{};
  GridCounts bricks_{};
  // `samples` is null until the brick is read.
  std::vector<Brick> read_;
};

// Values at multiples of kSpectrumSpacing, which is the unit.
template <typename Sample>
class CoarseValues {
 public:
  explicit CoarseValues(const PreparedVolume& volume)
      : samples_(volume.coarse.bytes()),
        extent_(coarse_extent(volume.info)),
        surroundings_{.last = (1 << volume.info.grid_exponent) >> kSpectrumExponent,
                      .outside = outside_value(volume.info)} {}

  void fill(const PlaceInCell& place, CellNeighbourhood& values) {
    const GridPoint low = place.cell - GridPoint{1, 1, 1};
    values.fill(place.corners, [&](int x, int y, int z) {
      const GridPoint p = low + GridPoint{x, y, z};
      if (!extent_.contains(p)) return surroundings_.beyond_data(p);
      Sample sample;
      std::memcpy(&sample, samples_.data() + sizeof(Sample) * extent_.index(p), sizeof(Sample));
      return static_cast<float>(sample);
    });
  }

 private:
  std::span<const std::byte> samples_;
  LevelExtent extent_;
  DataSurroundings surroundings_;
};

}  // namespace multitetra
