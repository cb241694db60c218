// The boxes behind tests/golden/shell_*.bin, computed with integers only: identical on all
// machines.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/sample_shells.hpp"

namespace multitetra::testing {

struct GoldenShell {
  std::string name;
  OwnedBox box;
  shell::ShellOptions options;
};

// Returns a pseudorandom number below `limit` for three coordinates.
inline std::int32_t scattered(int x, int y, int z, std::int32_t limit) {
  const auto mixed = static_cast<std::uint32_t>(x) * 73856093U ^
                     static_cast<std::uint32_t>(y) * 19349663U ^
                     static_cast<std::uint32_t>(z) * 83492791U;
  return static_cast<std::int32_t>((mixed * 2654435761U >> 8) % static_cast<std::uint32_t>(limit));
}

template <typename Sample, typename Value>
std::vector<Sample> samples_of(const std::array<std::int32_t, 3>& size, const Value& value) {
  std::vector<Sample> samples;
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) samples.push_back(static_cast<Sample>(value(x, y, z)));
    }
  }
  return samples;
}

inline std::vector<GoldenShell> golden_shells() {
  std::vector<GoldenShell> shells;
  const auto squared_distance = [](int x, int y, int z, int cx, int cy, int cz) {
    return (x - cx) * (x - cx) + (y - cy) * (y - cy) + (z - cz) * (z - cz);
  };
  {
    OwnedBox box{.samples = {}, .data_samples = {3, 3, 3}, .origin = {0, 0, 0}};
    box.samples = samples_of<std::uint8_t>(box.data_samples, [&](int x, int y, int z) {
      return 40 - 10 * squared_distance(x, y, z, 1, 1, 1);
    });
    shells.push_back({"example", box, {.isovalue = 34.5}});
  }
  {
    OwnedBox box{.samples = {},
                 .data_samples = {12, 11, 10},
                 .origin = {31, 4, 7},
                 .layers = 0x21,
                 .layer_value = -3.5};
    box.samples = samples_of<std::uint8_t>(box.data_samples, [&](int x, int y, int z) {
      const int value = 250 - 5 * squared_distance(x, y, z, 3, 5, 8) + scattered(x, y, z, 40);
      return value < 0 ? 0 : value > 255 ? 255 : value;
    });
    shells.push_back({"exact", box, {.isovalue = 120}});
  }
  {
    OwnedBox box{.samples = {}, .data_samples = {17, 16, 15}, .origin = {64, 0, 1}};
    box.samples = samples_of<float>(box.data_samples, [&](int x, int y, int z) {
      if (squared_distance(x, y, z, 12, 11, 3) < 9 || scattered(z, x, y, 60) == 0) {
        return std::numeric_limits<double>::quiet_NaN();
      }
      return squared_distance(x, y, z, 8, 6, 7) * 0.25 + scattered(x, y, z, 1024) * 0x1p-8;
    });
    shells.push_back(
        {"lattice_exact", box, {.isovalue = 9, .values = shell::ShellValues::kLatticeExact}});
  }
  {
    OwnedBox box{.samples = {},
                 .data_samples = {64, 8, 9},
                 .origin = {2, 5, 8},
                 .layers = 0x02,
                 .layer_value = 77};
    box.samples = samples_of<std::int16_t>(box.data_samples, [&](int x, int y, int z) {
      return 40 * (y - 4) + 3 * ((x % 16) - 8) * ((x % 16) - 8) - 30 * (z - 4) +
             scattered(x, y, z, 25) - 60;
    });
    shells.push_back({"quantized",
                      box,
                      {.isovalue = 0,
                       .values = shell::ShellValues::kQuantized,
                       .levels_per_octave = 2,
                       .lattice_resolution = 3,
                       .spacing_exponent = 2}});
  }
  return shells;
}

// FNV-1a, 32 bits, over the nine coordinates of all triangles in ascending order, each triangle
// starting at its smallest corner: the same for every decoder.
inline std::uint32_t checksum(const LatticeMesh& mesh) {
  std::uint32_t sum = 2166136261U;
  for (const LatticeTriangle& triangle : sorted_triangles(mesh)) {
    for (const LatticePoint& p : triangle) {
      for (const std::int32_t v : {p.x, p.y, p.z}) {
        sum = (sum ^ static_cast<std::uint32_t>(v)) * 16777619U;
      }
    }
  }
  return sum;
}

}  // namespace multitetra::testing
