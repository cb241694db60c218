// Byte order of numbers in files.
#pragma once

#include <cstddef>
#include <span>

namespace multitetra {

enum class Endian { kLittle, kBig };

// Converts numbers of `width` bytes (1, 2, 4 or 8) from the order `endian` to that of this machine.
// Requires whole numbers.
void to_host_order(std::span<std::byte> numbers, std::size_t width, Endian endian);

}  // namespace multitetra
