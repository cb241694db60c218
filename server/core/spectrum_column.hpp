// The error curves of spacings 1, 2 and 4 in a part of the volume, while its slices pass by.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/level_wavefront.hpp"
#include "server/core/spectrum_layout.hpp"

namespace multitetra {

// The cube centres of a level's last steps, kept for the next level.
class CubeRing {
 public:
  // Keeps the last `size` steps.
  explicit CubeRing(std::int32_t size) : layers_(static_cast<std::size_t>(size)) {}

  template <typename Real>
  void take(const LevelWavefront<Real>& level, std::int32_t k) {
    Step& step = layers_[slot(k)];
    step.k = k;
    level.copy_cubes(step.cubes);
  }
  // (x, y) in the level's units.
  [[nodiscard]] FoundCurve find(std::int32_t k, std::int32_t x, std::int32_t y) const {
    if (k < 0) return {};
    const Step& step = layers_[slot(k)];
    return step.k == k ? FoundCurve{step.cubes.find(x >> 1, y >> 1), &step.cubes} : FoundCurve{};
  }

 private:
  struct Step {
    std::int32_t k = -1;
    CurveLayer cubes;
  };
  [[nodiscard]] std::size_t slot(std::int32_t k) const {
    return static_cast<std::size_t>(k) % layers_.size();
  }

  std::vector<Step> layers_;
};

// The levels of spacing 1, 2 and 4 over some cells.
template <typename Real>
class SpectrumColumn {
 public:
  // Of cells that are done; the caller takes them before more than these are.
  static constexpr std::int32_t kStepsKept = 16;

  SpectrumColumn(const Grid& grid, const Vec3& spacing, const IsovalueBins& bins, GridPoint begin,
                 GridPoint end) {
    for (int e = 0; e < kFineLevels; ++e) {
      levels_.emplace_back(grid, spacing, bins, window_over_cells(grid, begin, end, e));
    }
  }

  // Takes the values of grid z and does what they make possible.
  void add(std::int32_t z, const PlaneSource& values) {
    for (int e = 0; e < kFineLevels; ++e) {
      LevelWavefront<Real>& level = levels_[static_cast<std::size_t>(e)];
      if (level.next_plane() << e == z) level.load_plane(values);
    }
    advance();
  }
  // The curve of the cell's centre; (x, y) in units of spacing 4.
  [[nodiscard]] FoundCurve find(std::int32_t k, std::int32_t x, std::int32_t y) const {
    return rings_[kFineLevels - 1].find(k, x, y);
  }
  [[nodiscard]] std::int32_t finished_cells() const { return levels_.back().next_step(); }

 private:
  static constexpr int kFineLevels = kSpectrumExponent;
  static constexpr std::int32_t kCell = kSpectrumSpacing;
  // Grid steps around the cells that the levels reach.
  static constexpr std::array<std::int32_t, kFineLevels> kSeam = {6, 4, 0};

  // The window of a level over cells begin ... end - 1 and a seam around them.
  static LevelWindow window_over_cells(const Grid& grid, GridPoint begin, GridPoint end,
                                       int exponent) {
    const std::int32_t seam = kSeam[static_cast<std::size_t>(exponent)];
    const auto low = [&](std::int32_t cell) {
      return std::max(0, kCell * cell - seam) >> exponent;
    };
    const auto high = [&](std::int32_t cell) {
      return std::min(grid.side(), kCell * cell + seam) >> exponent;
    };
    LevelWindow window{
        .exponent = exponent, .low = {low(begin.x), low(begin.y), low(begin.z)}, .extent = {}};
    window.extent =
        GridPoint{high(end.x), high(end.y), high(end.z)} - window.low + GridPoint{1, 1, 1};
    return window;
  }

  void advance() {
    for (std::size_t e = 0; e < levels_.size(); ++e) {
      LevelWavefront<Real>& level = levels_[e];
      CubeCurve finer;
      if (e > 0) {
        finer = [this, e](std::int32_t k, std::int32_t x, std::int32_t y) {
          return rings_[e - 1].find(k, x, y);
        };
      }
      while (!level.is_done() && level.has_values() && has_finer(e, level.next_step())) {
        const std::int32_t k = level.next_step();
        level.step(finer);
        rings_[e].take(level, k);
      }
    }
  }
  [[nodiscard]] bool has_finer(std::size_t e, std::int32_t k) const {
    if (e == 0) return true;
    const LevelWavefront<Real>& finer = levels_[e - 1];
    return finer.is_done() || finer.next_step() > 2 * k + 2;
  }

  std::vector<LevelWavefront<Real>> levels_;
  std::array<CubeRing, kFineLevels> rings_ = {CubeRing(4), CubeRing(4), CubeRing(kStepsKept)};
};

}  // namespace multitetra
