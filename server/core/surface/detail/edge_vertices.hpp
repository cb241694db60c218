// The vertices on the framework's edges in one octree cube: triangles that meet at an edge find its
// vertex without a search.
//
// An edge is identified by its midpoint. If the edge's extents are even, it is the only edge that
// this point splits; if they are 1, the midpoint is the middle of an edge, face or cube of side 1,
// and the parities of the ends allow only one diagonal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/framework/grid.hpp"

namespace multitetra {

// A slot for every half step, in blocks allocated on first use. About 12 MB if the surface fills a
// cube of side 64; reuse it.
class EdgeVertices {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // Clears all slots. The edges used afterwards must lie in the closed cube, with coordinates that
  // are multiples of 2^exponent, which is at most the cube's side.
  void begin(const OctreeCube& cube, int exponent) {
    const auto low = [&](std::int32_t position) { return 2 * position * cube.side(); };
    low_ = {low(cube.x), low(cube.y), low(cube.z)};
    exponent_ = exponent;
    blocks_ = (2 * cube.side() >> exponent >> kBlockBits) + 1;
    const auto count = static_cast<std::size_t>(blocks_);
    block_of_.assign(count * count * count, kNone);
    used_ = 0;
  }

  // Returns the slot for the number of an edge's vertex, kNone at first; `ends` is the sum of the
  // edge's ends. The reference is valid until the next call.
  [[nodiscard]] std::uint32_t& at(GridPoint ends) {
    const GridPoint half_steps = ends - low_;
    const std::int32_t x = half_steps.x >> exponent_;
    const std::int32_t y = half_steps.y >> exponent_;
    const std::int32_t z = half_steps.z >> exponent_;
    std::uint32_t& block = block_of_[static_cast<std::size_t>(
        (x >> kBlockBits) + blocks_ * ((y >> kBlockBits) + blocks_ * (z >> kBlockBits)))];
    if (block == kNone) block = new_block();
    const auto within = [](std::int32_t v) {
      return static_cast<std::size_t>(v & ((1 << kBlockBits) - 1));
    };
    return slots_[block][within(x) | within(y) << kBlockBits | within(z) << (2 * kBlockBits)];
  }

 private:
  static constexpr int kBlockBits = 3;
  using Block = std::array<std::uint32_t, 1 << (3 * kBlockBits)>;

  std::uint32_t new_block() {
    if (used_ == slots_.size()) slots_.emplace_back();
    slots_[used_].fill(kNone);
    return static_cast<std::uint32_t>(used_++);
  }

  GridPoint low_;  // Twice the cube's lowest corner.
  int exponent_ = 0;
  std::int32_t blocks_ = 0;  // Blocks along an axis.
  std::vector<std::uint32_t> block_of_;
  std::vector<Block> slots_;
  std::size_t used_ = 0;
};

}  // namespace multitetra
