// Bricks of bytes, packed without loss: blosc's bit shuffle with LZ4, which unpacks at gigabytes a
// second, or with zstd for smooth floats where that saves a quarter; raw where neither pays. The
// same bytes for the same brick, on any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multitetra {

// As stored: do not renumber.
enum class BrickCodec : std::uint8_t {
  kRaw = 0,       // The bytes as they are.
  kConstant = 1,  // One item, which is repeated.
  kBlosc = 2,     // A frame of blosc, which contains its unpacked length.
};

struct PackedBrick {
  BrickCodec codec = BrickCodec::kRaw;
  std::vector<std::byte> bytes;
};

// Items of 1, 2 or 4 bytes; requires whole ones.
[[nodiscard]] PackedBrick pack_brick(std::span<const std::byte> brick, std::size_t item_bytes);
// The same for bytes whose number the reader does not know: never kConstant.
[[nodiscard]] PackedBrick pack_sized(std::span<const std::byte> bytes);

// The number of unpacked bytes; nullopt when that cannot be seen: of a constant brick, or where
// they are no frame.
[[nodiscard]] std::optional<std::size_t> unpacked_size(BrickCodec codec,
                                                       std::span<const std::byte> packed);

// Whether `packed` is a brick of exactly into.size() bytes, which are there then. Reads and writes
// nothing beyond the two spans whatever the bytes are.
[[nodiscard]] bool unpack_brick(BrickCodec codec, std::span<const std::byte> packed,
                                std::span<std::byte> into);

}  // namespace multitetra
