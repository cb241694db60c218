// One level of a spectrum, of spacing 8 or more, divided into independent blocks.
//
// A block is a box of the level's bricks. It reads the curves of the finer level's cube centers
// from the scratch, computes its own points and two more along x and y on each side (a cube center
// needs the faces around it, and these need their edges), and stores its own cube centers'.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/spectrum/detail/curve_tiles.hpp"
#include "server/core/spectrum/detail/level_wavefront.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

template <typename Real>
class CoarseLevel {
 public:
  struct Brick {
    std::size_t index;
    std::vector<std::byte> bytes;
  };

  // All references must outlive the level.
  CoarseLevel(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumLayout::Level& level,
              const CoarseVolume& samples, const CurveSource& finer, Scratch& scratch);

  // Returns the maximum memory of a block in bytes: three layers of its own curves and four of the
  // finer level's, with 25 % spare capacity, and for all points one byte for each of three codes,
  // doubled for one layer of bricks.
  [[nodiscard]] static std::size_t max_bytes(int bins) {
    constexpr std::size_t kSide = SpectrumLayout::kSide;
    constexpr std::size_t kPlaces = (kSide * kBricks.x + 5) * (kSide * kBricks.y + 5);
    constexpr std::size_t kBlockBricks = std::size_t{kBricks.x} * kBricks.y * (kBricks.z + 2);
    const std::size_t curve_blocks = (static_cast<std::size_t>(bins) + 3) / 4;
    return 9 * kPlaces * (curve_blocks * sizeof(CurveBlock) + 16) +
           kBlockBricks * (3 * SpectrumLayout::kPoints + 64) * static_cast<std::size_t>(bins);
  }

  [[nodiscard]] std::size_t blocks() const { return blocks_.size(); }
  // Computes the nonempty bricks of one block. Must be called once for each block, from any thread.
  [[nodiscard]] std::vector<Brick> make(std::size_t block);
  // Complete after make() has returned for all blocks.
  [[nodiscard]] const CurveTiles& cubes() const { return cubes_; }

 private:
  static constexpr GridPoint kBricks = {4, 4, 8};  // Bricks in a block.

  [[nodiscard]] static CurveTiles tiles_of(const LevelExtent& extent, Scratch& scratch);
  [[nodiscard]] GridPoint begin_of(std::size_t block) const;  // In units of the level.

  const DatasetInfo& info_;
  const IsovalueBins& bins_;
  const SpectrumLayout::Level& level_;
  const CoarseVolume& samples_;
  const CurveSource& finer_;
  BrickLayout blocks_;
  CurveTiles cubes_;
};

extern template class CoarseLevel<float>;
extern template class CoarseLevel<double>;

}  // namespace multitetra
