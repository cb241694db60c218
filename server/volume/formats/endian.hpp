// The order of the bytes of a number in a file.
#pragma once

#include <cstddef>
#include <span>

namespace multitetra {

enum class Endian { kLittle, kBig };

// Turns numbers of `width` bytes (1, 2, 4 or 8) that a file has in the order `endian` into those of
// this machine. Requires whole numbers.
void to_host_order(std::span<std::byte> numbers, std::size_t width, Endian endian);

}  // namespace multitetra
