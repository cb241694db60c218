// The box around the positions of a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace multitetra {

// Returns the lowest and highest corner of the box around positions, of which there must be one.
[[nodiscard]] inline std::pair<std::array<float, 3>, std::array<float, 3>> position_bounds(
    const std::vector<std::array<float, 3>>& positions) {
  std::pair box(positions.front(), positions.front());
  for (const std::array<float, 3>& position : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = std::min(box.first[axis], position[axis]);
      box.second[axis] = std::max(box.second[axis], position[axis]);
    }
  }
  return box;
}

}  // namespace multitetra
