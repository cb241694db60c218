// Lossless compression of bricks: blosc's bit shuffle with LZ4, which unpacks gigabytes per second,
// or with zstd for smooth floats where that saves a quarter; raw where neither pays. Deterministic:
// equal bricks give equal bytes, on any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multitetra {

// Stored values: do not renumber.
enum class BrickCodec : std::uint8_t {
  kRaw = 0,       // The bytes themselves.
  kConstant = 1,  // One item, repeated.
  kBlosc = 2,     // A blosc frame, which contains its unpacked size.
};

struct PackedBrick {
  BrickCodec codec = BrickCodec::kRaw;
  std::vector<std::byte> bytes;
};

// Packs whole items of 1, 2 or 4 bytes.
[[nodiscard]] PackedBrick pack_brick(std::span<const std::byte> brick, std::size_t item_bytes);
// Packs bytes so that unpacked_size() finds their number: never kConstant.
[[nodiscard]] PackedBrick pack_sized(std::span<const std::byte> bytes);

// Returns the number of unpacked bytes, or nullopt for a constant brick or an invalid frame.
[[nodiscard]] std::optional<std::size_t> unpacked_size(BrickCodec codec,
                                                       std::span<const std::byte> packed);

// Unpacks a brick. Returns whether it has exactly into.size() bytes. Never accesses memory outside
// the two spans, whatever the bytes are.
[[nodiscard]] bool unpack_brick(BrickCodec codec, std::span<const std::byte> packed,
                                std::span<std::byte> into);

}  // namespace multitetra
