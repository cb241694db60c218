// Levels of distances |v - c|, found by comparisons: logarithms may differ between machines.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace multitetra::shell {

// 2^((2 i + 1) / (2 L)) as the bits of a mantissa without its leading one, i = 0 .. L - 1.
inline constexpr std::array<std::uint64_t, 8> kLevelEnds8 = {
    0xb5586cf98910,  0x2387a6e756239, 0x3dea64c123423, 0x5ab07dd48542a,
    0x7a11473eb0187, 0x9c49182a3f091, 0xc199bdd85529d, 0xea4afa2a490da};
inline constexpr std::array<std::uint64_t, 4> kLevelEnds4 = {0x172b83c7d517b, 0x4bfdad5362a28,
                                                             0x8ace5422aa0dc, 0xd5818dcfba488};
inline constexpr std::array<std::uint64_t, 2> kLevelEnds2 = {0x306fe0a31b716, 0xae89f995ad3ae};
inline constexpr std::array<std::uint64_t, 1> kLevelEnds1 = {0x6a09e667f3bcd};

template <std::size_t kCount>
[[nodiscard]] inline std::int32_t levels_below(const std::array<std::uint64_t, kCount>& ends,
                                               std::uint64_t mantissa) {
  std::int32_t below = 0;
  for (const std::uint64_t end : ends) below += mantissa >= end ? 1 : 0;
  return below;
}

// Returns L log2(distance), rounded. Requires 0 < distance < infinity.
[[nodiscard]] inline std::int32_t level_of_distance(double distance, int levels_per_octave) {
  int scaled = 0;
  if (distance < 0x1p-1022) {  // A subnormal number has no leading one.
    distance *= 0x1p100;
    scaled = 100;
  }
  const auto bits = std::bit_cast<std::uint64_t>(distance);
  const std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  const auto octave = static_cast<std::int32_t>(bits >> 52) - 1023 - scaled;
  switch (levels_per_octave) {
    case 1:
      return octave + levels_below(kLevelEnds1, mantissa);
    case 2:
      return 2 * octave + levels_below(kLevelEnds2, mantissa);
    case 4:
      return 4 * octave + levels_below(kLevelEnds4, mantissa);
    default:
      return 8 * octave + levels_below(kLevelEnds8, mantissa);
  }
}

}  // namespace multitetra::shell
