// Small volumes for tests of guarantees: smooth, noisy, flat, masked, stretched. All are seeded and
// identical on all machines.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "server/core/framework/volume.hpp"

namespace multitetra::testing::fields {

// Samples `value(x, y, z)`, whose coordinates are sample indices.
template <typename Sample>
Volume sampled(std::array<std::int32_t, 3> dims, const std::function<double(int, int, int)>& value,
               Vec3 spacing = {1, 1, 1}) {
  std::vector<Sample> samples;
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) samples.push_back(static_cast<Sample>(value(x, y, z)));
    }
  }
  Volume volume{
      .dims = dims, .spacing = spacing, .index_to_world = {}, .samples = std::move(samples)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    volume.index_to_world.columns[axis][axis] = spacing[axis];
  return volume;
}

// Returns a number in [0, 1) from 53 bits: identical with every standard library, unlike its
// distributions.
inline double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

inline Volume noise(std::array<std::int32_t, 3> dims, std::uint64_t seed,
                    Vec3 spacing = {1, 1, 1}) {
  std::mt19937_64 random(seed);
  return sampled<float>(
      dims, [&](int, int, int) { return uniform(random); }, spacing);
}

// Integers 0 .. levels - 1: plateaus and ties everywhere.
inline Volume integer_noise(std::array<std::int32_t, 3> dims, int levels, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return sampled<std::uint8_t>(dims,
                               [&](int, int, int) { return std::floor(levels * uniform(random)); });
}

inline Volume gyroid(int side, double amplitude, std::uint64_t seed, Vec3 spacing = {1, 1, 1}) {
  std::mt19937_64 random(seed);
  const double k = 4 * 3.14159265358979323846 / (side - 1);
  return sampled<float>(
      {side, side, side},
      [&](int x, int y, int z) {
        return std::sin(k * x) * std::cos(k * y) + std::sin(k * y) * std::cos(k * z) +
               std::sin(k * z) * std::cos(k * x) + amplitude * (uniform(random) - 0.5);
      },
      spacing);
}

// Positive inside.
inline Volume ball(std::array<std::int32_t, 3> dims, double radius) {
  const auto centered = [](int v, int n) { return v - 0.5 * (n - 1); };
  return sampled<float>(dims, [&](int x, int y, int z) {
    const double dx = centered(x, dims[0]);
    const double dy = centered(y, dims[1]);
    const double dz = centered(z, dims[2]);
    return radius - std::sqrt(dx * dx + dy * dy + dz * dz);
  });
}

// A gyroid with holes in the data: samples of a ball and some single ones are void.
inline Volume masked_gyroid(int side, std::uint64_t seed) {
  Volume volume = gyroid(side, 0.3, seed);
  std::mt19937_64 random(seed + 1);
  auto& samples = std::get<std::vector<float>>(volume.samples);
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const double d = std::hypot(x - 0.3 * side, y - 0.4 * side, z - 0.6 * side);
        if (d < 0.2 * side || uniform(random) < 0.003) {
          samples[volume.index(x, y, z)] = std::numeric_limits<float>::quiet_NaN();
        }
      }
    }
  }
  return volume;
}

}  // namespace multitetra::testing::fields
