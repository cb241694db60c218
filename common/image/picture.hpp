// An image in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace multitetra {

// Red, green, blue in sRGB, and opacity, not premultiplied.
using Pixel = std::array<std::uint8_t, 4>;

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels = {};  // Row by row from the top, each from the left.

  [[nodiscard]] const Pixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

}  // namespace multitetra
