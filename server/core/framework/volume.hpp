// A regular scalar volume: samples on a grid with spacing in world units.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "common/base/affine.hpp"
#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Samples, x fastest, in their stored type. The alternatives have the order of SampleType.
using Samples =
    std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
                 std::vector<std::int16_t>, std::vector<float>>;

struct Volume {
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each at least 1.
  Vec3 spacing = {1, 1, 1};            // World units between samples, > 0.
  // Maps sample indices to world coordinates, spacing included.
  Affine index_to_world;
  PhysicalMeaning meaning = {};
  Samples samples;  // dims[0] * dims[1] * dims[2] samples; NaN is void.

  [[nodiscard]] SampleType type() const { return static_cast<SampleType>(samples.index()); }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) *
           static_cast<std::size_t>(dims[2]);
  }
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(dims[0]) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(z));
  }
};

}  // namespace multitetra
