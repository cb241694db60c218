#include "server/core/spectrum/detail/coarse_level.hpp"

#include <algorithm>
#include <cassert>

#include "server/core/spectrum/detail/spectrum_brick.hpp"

namespace multitetra {
namespace {

// The layer of a block's bricks that is being filled.
class BrickLayer {
 public:
  // Covers the points begin ... end - 1 of the level.
  BrickLayer(const SpectrumLayout::Level& level, GridPoint begin, GridPoint end, float voxel)
      : level_(level), begin_(begin), end_(end), voxel_(voxel) {
    const auto bricks = [](std::int32_t points) {
      return (points + SpectrumLayout::kSide - 1) / SpectrumLayout::kSide;
    };
    across_ = bricks(end.x - begin.x);
    builders_.resize(static_cast<std::size_t>(across_ * bricks(end.y - begin.y)));
  }

  // Adds the points of layer z that have exactly this level's spacing.
  void add(std::int32_t z, const CurveLayer& layer) {
    for (std::int32_t y = begin_.y; y < end_.y; ++y) {
      for (std::int32_t x = begin_.x; x < end_.x; ++x) {
        const CurveLayer::Curve curve = layer.at(x, y);
        if (curve.count == 0) continue;
        const std::int32_t builder = (x - begin_.x) / SpectrumLayout::kSide +
                                     across_ * ((y - begin_.y) / SpectrumLayout::kSide);
        builders_[static_cast<std::size_t>(builder)].add(
            SpectrumLayout::place(level_, {x, y, z}).point, layer.blocks(curve), curve, voxel_);
      }
    }
  }
  // Returns whether z is the last layer of points in its layer of bricks.
  [[nodiscard]] bool ends_with(std::int32_t z) const {
    return (z - begin_.z) % SpectrumLayout::kSide == SpectrumLayout::kSide - 1 || z == end_.z - 1;
  }
  template <typename Brick>
  void take(std::int32_t z, std::vector<Brick>& into) {
    for (std::size_t i = 0; i < builders_.size(); ++i) {
      std::vector<std::byte> bytes = builders_[i].take();
      if (bytes.empty()) continue;
      const auto at = static_cast<std::int32_t>(i);
      const GridPoint first = {begin_.x + SpectrumLayout::kSide * (at % across_),
                               begin_.y + SpectrumLayout::kSide * (at / across_), z};
      into.push_back({SpectrumLayout::place(level_, first).brick, std::move(bytes)});
    }
  }

 private:
  const SpectrumLayout::Level& level_;
  GridPoint begin_;
  GridPoint end_;
  float voxel_;
  std::int32_t across_ = 0;  // Number of bricks along x.
  std::vector<SpectrumBrickBuilder> builders_;
};

// Returns the points that a block over begin ... end - 1 computes: two more on each side along x
// and y, and the even layers around its odd ones.
LevelWindow window_of(const LevelExtent& level, GridPoint begin, GridPoint end) {
  const GridPoint level_end = level.low + level.extent;
  LevelWindow window{
      .exponent = level.exponent,
      .low = {std::max(level.low.x, begin.x - 2), std::max(level.low.y, begin.y - 2), begin.z & ~1},
      .extent = {}};
  window.extent = GridPoint{std::min(level_end.x, end.x + 2), std::min(level_end.y, end.y + 2),
                            (end.z & ~1) + 1} -
                  window.low;
  if (window.extent.z == 1) {  // Even layers are computed only within steps.
    window.low.z = std::max(0, window.low.z - 2);
    window.extent.z += 2;
  }
  return window;
}

}  // namespace

template <typename Real>
CoarseLevel<Real>::CoarseLevel(const DatasetInfo& info, const IsovalueBins& bins,
                               const SpectrumLayout::Level& level, const CoarseVolume& samples,
                               const CurveSource& finer, Scratch& scratch)
    : info_(info),
      bins_(bins),
      level_(level),
      samples_(samples),
      finer_(finer),
      blocks_({(level.bricks.counts()[0] + kBricks.x - 1) / kBricks.x,
               (level.bricks.counts()[1] + kBricks.y - 1) / kBricks.y,
               (level.bricks.counts()[2] + kBricks.z - 1) / kBricks.z},
              1),
      cubes_(tiles_of(level.extent, scratch)) {}

template <typename Real>
CurveTiles CoarseLevel<Real>::tiles_of(const LevelExtent& extent, Scratch& scratch) {
  const GridPoint low = {extent.low.x >> 1, extent.low.y >> 1, extent.low.z >> 1};
  const GridPoint last = extent.low + extent.extent - GridPoint{1, 1, 1};
  const GridPoint end = {(last.x >> 1) + 1, (last.y >> 1) + 1, (last.z >> 1) + 1};
  const std::int32_t half = SpectrumLayout::kSide / 2;
  return {low, end, {half * kBricks.x, half * kBricks.y, 1}, scratch};
}

template <typename Real>
GridPoint CoarseLevel<Real>::begin_of(std::size_t block) const {
  const auto [x, y, z] = blocks_.at(block);
  return level_.extent.low +
         SpectrumLayout::kSide * GridPoint{x * kBricks.x, y * kBricks.y, z * kBricks.z};
}

template <typename Real>
std::vector<typename CoarseLevel<Real>::Brick> CoarseLevel<Real>::make(std::size_t block) {
  const GridPoint begin = begin_of(block);
  const GridPoint most = begin + SpectrumLayout::kSide * kBricks;
  const GridPoint level_end = level_.extent.low + level_.extent.extent;
  const GridPoint end = {std::min(most.x, level_end.x), std::min(most.y, level_end.y),
                         std::min(most.z, level_end.z)};
  LevelWavefront<Real> points(grid_of(info_), info_.spacing, bins_,
                              window_of(level_.extent, begin, end));
  FinerLayers finer(finer_, points.window());
  BrickLayer layer(level_, begin, end, static_cast<float>(voxel_length(info_)));
  std::vector<Brick> bricks;
  const auto write = [&](std::int32_t z, const CurveLayer& curves) {
    if (z < begin.z || z >= end.z) return;
    layer.add(z, curves);
    if (layer.ends_with(z)) layer.take(z, bricks);
  };
  while (!points.is_done()) {
    while (!points.has_values()) points.load_plane(samples_);
    const std::int32_t k = points.next_step();
    points.step(finer.around(k));
    write(2 * k, points.lower());
    write(2 * k + 1, points.middle());
    if (points.is_done()) write(2 * k + 2, points.upper());
    if (2 * k + 1 >= begin.z && 2 * k + 1 < end.z) {
      cubes_.put({begin.x >> 1, begin.y >> 1, k}, points.middle());
    }
  }
  return bricks;
}

template class CoarseLevel<float>;
template class CoarseLevel<double>;

}  // namespace multitetra
