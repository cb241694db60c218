#include "server/volume/formats/endian.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace multitetra {
namespace {

// Swaps the bytes of every number. The constant width permits one instruction per number.
template <typename Number>
void turn_numbers(std::span<std::byte> bytes) {
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(Number)) {
    std::array<std::byte, sizeof(Number)> number;
    std::memcpy(number.data(), bytes.data() + at, sizeof(Number));
    std::reverse(number.begin(), number.end());
    std::memcpy(bytes.data() + at, number.data(), sizeof(Number));
  }
}

}  // namespace

void to_host_order(std::span<std::byte> numbers, std::size_t width, Endian endian) {
  constexpr bool kHostIsLittle = std::endian::native == std::endian::little;
  if ((endian == Endian::kLittle) == kHostIsLittle) return;
  if (width == 2) turn_numbers<std::uint16_t>(numbers);
  if (width == 4) turn_numbers<std::uint32_t>(numbers);
  if (width == 8) turn_numbers<std::uint64_t>(numbers);
}

}  // namespace multitetra
