// Noise for generated samples with the same bits on every machine: pure integer arithmetic without
// state, so any thread can compute any sample.
#pragma once

#include <cstdint>

namespace multitetra {

// The finalizer of SplitMix64 (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number
// Generators", OOPSLA 2014): a bijection that scatters consecutive numbers.
[[nodiscard]] constexpr std::uint64_t scattered(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

// Returns a number between -6 and 6 for each `index`, nearly normal with mean 0 and standard
// deviation 1: the centered and scaled sum of twelve uniform 16-bit integers (Irwin-Hall).
[[nodiscard]] constexpr double sample_noise(std::uint64_t seed, std::uint64_t index) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15u;
  constexpr std::int32_t kTwiceMean = 12 * 65535;
  const std::uint64_t start = scattered(seed + kGolden);
  std::int32_t sum = 0;
  for (std::uint64_t word = 0; word < 3; ++word) {
    const std::uint64_t bits = scattered(start + kGolden * (3 * index + word));
    for (int part = 0; part < 4; ++part) {
      sum += static_cast<std::int32_t>(bits >> (16 * part) & 0xFFFFu);
    }
  }
  return static_cast<double>(2 * sum - kTwiceMean) / 131072.0;
}

}  // namespace multitetra
