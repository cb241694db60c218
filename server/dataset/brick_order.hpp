// The order of bricks in a file. Neighbors in the volume are close in the file, so reading a region
// takes few ranges.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// Calls visit(brick) in Morton order: the lower half along z first, within each half the lower half
// along y, and so on. Aligned cubes whose side is a power of two are therefore contiguous.
template <typename Visit>
void in_morton_order(const BrickLayout& layout, const Visit& visit) {
  std::int32_t side = 1;
  for (const std::int32_t count : layout.counts()) {
    while (side < count) side *= 2;
  }
  const auto octants = [&](const auto& self, const GridCounts& low, std::int32_t cube) -> void {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (low[axis] >= layout.counts()[axis]) return;
    }
    if (cube == 1) {
      visit(layout.index(low));
      return;
    }
    const std::int32_t half = cube / 2;
    for (std::int32_t octant = 0; octant < 8; ++octant) {
      self(self,
           {low[0] + (octant & 1) * half, low[1] + (octant >> 1 & 1) * half,
            low[2] + (octant >> 2) * half},
           half);
    }
  };
  octants(octants, {0, 0, 0}, side);
}

// Visits the bricks of a spectrum from the coarsest level to the finest, each in Morton order.
template <typename Visit>
void in_file_order(const SpectrumLayout& layout, const Visit& visit) {
  for (auto level = layout.levels().rbegin(); level != layout.levels().rend(); ++level) {
    in_morton_order(level->bricks, [&](std::size_t brick) { visit(level->first_brick + brick); });
  }
}

// Visits the bricks of samples in Morton order.
template <typename Visit>
void in_file_order(const BrickLayout& layout, const Visit& visit) {
  in_morton_order(layout, visit);
}

}  // namespace multitetra
