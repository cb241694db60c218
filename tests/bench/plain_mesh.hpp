// A mesh of other libraries in their own coordinates. C++17, as their headers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace multitetra {

struct PlainMesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace multitetra
