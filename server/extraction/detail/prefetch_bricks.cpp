#include "server/extraction/detail/prefetch_bricks.hpp"

#include <algorithm>
#include <vector>

namespace multitetra {
namespace {

// Appends the bricks of `layout` that contain any of the items from `low` to `high`, both included.
void add_bricks(const BrickLayout& layout, GridPoint low, GridPoint high, std::size_t first_brick,
                std::vector<std::size_t>& bricks) {
  GridCounts begin{};
  GridCounts end{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::int32_t last = layout.dims()[i] - 1;
    if (high[axis] < 0 || low[axis] > last) return;
    begin[i] = std::clamp(low[axis], 0, last) / layout.side();
    end[i] = std::clamp(high[axis], 0, last) / layout.side() + 1;
  }
  for (std::int32_t z = begin[2]; z < end[2]; ++z) {
    for (std::int32_t y = begin[1]; y < end[1]; ++y) {
      for (std::int32_t x = begin[0]; x < end[0]; ++x) {
        bricks.push_back(first_brick + layout.index({x, y, z}));
      }
    }
  }
}

struct CubeCorners {
  GridPoint low;
  GridPoint high;

  explicit CubeCorners(const OctreeCube& cube)
      : low(cube.side() * GridPoint{cube.x, cube.y, cube.z}),
        high(low + GridPoint{cube.side(), cube.side(), cube.side()}) {}
};

std::vector<std::size_t> spectrum_bricks(const SpectrumLayout& layout,
                                         std::span<const OctreeCube> cubes, int finest_exponent) {
  std::vector<std::size_t> bricks;
  for (auto level = layout.levels().rbegin(); level != layout.levels().rend(); ++level) {
    const int exponent = level->extent.exponent;
    if (exponent < finest_exponent) break;
    for (const OctreeCube& cube : cubes) {
      const CubeCorners box(cube);
      add_bricks(level->bricks, level->extent.unit_point(box.low) - level->extent.low,
                 level->extent.unit_point(box.high) - level->extent.low, level->first_brick,
                 bricks);
    }
  }
  return bricks;
}

// Fine errors in a cell depend on the samples of the surrounding cells.
std::vector<std::size_t> sample_bricks(const DatasetInfo& info, std::span<const OctreeCube> cubes) {
  constexpr GridPoint kCell = {kSpectrumSpacing, kSpectrumSpacing, kSpectrumSpacing};
  const BrickLayout layout(info.dims);
  std::vector<std::size_t> bricks;
  for (const OctreeCube& cube : cubes) {
    const CubeCorners box(cube);
    add_bricks(layout, box.low - first_sample(info) - kCell, box.high - first_sample(info) + kCell,
               0, bricks);
  }
  return bricks;
}

}  // namespace

std::uint64_t spectrum_bytes_to_fetch(const PreparedVolume& volume, std::int32_t finest_spacing) {
  const auto& spectrum = volume.spectrum.bricks;
  if (!spectrum || !spectrum->is_remote()) return 0;
  std::vector<std::size_t> bricks;
  for (const SpectrumLayout::Level& level : volume.spectrum.layout.levels()) {
    if (level.extent.exponent < exponent_of(finest_spacing)) continue;
    for (std::size_t i = 0; i < level.bricks.size(); ++i) bricks.push_back(level.first_brick + i);
  }
  return spectrum->bytes_to_fetch(bricks);
}

void prefetch_bricks(const PreparedVolume& volume, std::span<const OctreeCube> cubes,
                     std::int32_t finest_spacing) {
  if (volume.spectrum.bricks && volume.spectrum.bricks->is_remote()) {
    volume.spectrum.bricks->prefetch(
        spectrum_bricks(volume.spectrum.layout, cubes, exponent_of(finest_spacing)));
  }
  if (finest_spacing < kSpectrumSpacing && volume.samples->is_remote()) {
    volume.samples->prefetch(sample_bricks(volume.info, cubes));
  }
}

}  // namespace multitetra
