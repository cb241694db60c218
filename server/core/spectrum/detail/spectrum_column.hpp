// The error curves of spacings 1, 2 and 4 in a part of the volume, computed slice by slice.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/spectrum/detail/level_wavefront.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// The levels of spacing 1, 2 and 4 over a box of cells.
template <typename Real>
class SpectrumColumn {
 public:
  // Grid steps around the cells within which values are needed: six, and a diamond.
  static constexpr std::int32_t kReach = kSpectrumReach;

  // Returns the maximum memory, in bytes, of a column over cells_x * cells_y cells. Every position
  // along x and y needs at most 3.5 curves of spacing 1 (three quarters of the points of an even
  // layer, twice; those of an odd layer; and the cube centers of four steps), a quarter of that for
  // spacing 2 and less for spacing 4, or 4.6 in all. The layers have up to 25 % spare capacity.
  [[nodiscard]] static std::size_t max_bytes(std::int32_t cells_x, std::int32_t cells_y, int bins) {
    const auto along = [](std::int32_t cells) {
      return static_cast<std::size_t>(kCell * cells + 2 * kHaloSteps[0] + 1);
    };
    const std::size_t blocks = (static_cast<std::size_t>(bins) + 3) / 4;
    return along(cells_x) * along(cells_y) * (6 * blocks * sizeof(CurveBlock) + 64);
  }

  SpectrumColumn(const Grid& grid, const Vec3& spacing, const IsovalueBins& bins, GridPoint begin,
                 GridPoint end) {
    for (int e = 0; e < kFineLevels; ++e) {
      levels_.emplace_back(grid, spacing, bins, window_over_cells(grid, begin, end, e));
    }
  }

  // Adds the values of grid z and computes what they allow. Calls done(k, layer) for each completed
  // layer k of cells, in order; the layer contains the cells' centers, in units of spacing 4.
  template <typename Done>
  void add(std::int32_t z, const PlaneSource& values, const Done& done) {
    for (int e = 0; e < kFineLevels; ++e) {
      LevelWavefront<Real>& level = levels_[static_cast<std::size_t>(e)];
      if (level.next_plane() << e == z) level.load_plane(values);
    }
    for (std::size_t e = 0; e < levels_.size(); ++e) {
      while (can_step(e)) {
        const std::int32_t k = levels_[e].next_step();
        levels_[e].step(e == 0 ? FinerCubes() : rings_[e - 1].around(k));
        e + 1 < levels_.size() ? rings_[e].take(levels_[e], k) : done(k, levels_[e].middle());
      }
    }
  }
  [[nodiscard]] bool is_done() const { return levels_.back().is_done(); }

 private:
  static constexpr int kFineLevels = kSpectrumExponent;
  static constexpr std::int32_t kCell = kSpectrumSpacing;
  // Grid steps around the cells that each level covers.
  static constexpr std::array<std::int32_t, kFineLevels> kHaloSteps = {6, 4, 0};

  // The cube centers of a level's last four steps, for the next level.
  class CubeRing {
   public:
    void take(const LevelWavefront<Real>& level, std::int32_t k) {
      Step& step = steps_[static_cast<std::size_t>(k) % steps_.size()];
      step.k = k;
      level.copy_cubes(step.cubes);
    }
    [[nodiscard]] FinerCubes around(std::int32_t k) const {
      FinerCubes cubes;
      for (const Step& step : steps_) {
        if (step.k >= 2 * k - 1) cubes.add(step.k, step.cubes);
      }
      return cubes;
    }

   private:
    struct Step {
      std::int32_t k = -2;
      CurveLayer cubes;
    };
    std::array<Step, 4> steps_;
  };

  // Returns the window of a level over the cells begin ... end - 1 and the seam around them.
  static LevelWindow window_over_cells(const Grid& grid, GridPoint begin, GridPoint end,
                                       int exponent) {
    const std::int32_t seam = kHaloSteps[static_cast<std::size_t>(exponent)];
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

  [[nodiscard]] bool can_step(std::size_t e) const {
    const LevelWavefront<Real>& level = levels_[e];
    if (level.is_done() || !level.has_values()) return false;
    if (e == 0) return true;
    const LevelWavefront<Real>& finer = levels_[e - 1];
    return finer.is_done() || finer.next_step() > 2 * level.next_step() + 2;
  }

  std::vector<LevelWavefront<Real>> levels_;
  std::array<CubeRing, kFineLevels - 1> rings_;
};

}  // namespace multitetra
