#include "server/dataset/brick_codec.hpp"

#include <blosc.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace multitetra {
namespace {

constexpr int kLz4Level = 5;
constexpr int kZstdLevel = 2;
constexpr int kOneThread = 1;
constexpr std::size_t kBlockBytes = 0;  // Chosen by blosc from the effort and the size alone.

bool is_constant(std::span<const std::byte> brick, std::size_t item_bytes) {
  return brick.size() > item_bytes &&
         std::equal(brick.begin() + static_cast<std::ptrdiff_t>(item_bytes), brick.end(),
                    brick.begin());
}

// Returns a blosc frame of at most `max_bytes` bytes, or nothing if that does not suffice.
std::vector<std::byte> frame_of(std::span<const std::byte> brick, std::size_t item_bytes,
                                const char* compressor, int effort, std::size_t max_bytes) {
  std::vector<std::byte> packed(max_bytes);
  const int size =
      max_bytes > BLOSC_MIN_HEADER_LENGTH
          ? blosc_compress_ctx(effort, BLOSC_BITSHUFFLE, item_bytes, brick.size(), brick.data(),
                               packed.data(), packed.size(), compressor, kBlockBytes, kOneThread)
          : 0;
  packed.resize(static_cast<std::size_t>(std::max(size, 0)));
  return packed;
}

// Tries a slower compressor if the fast one gives fewer bytes than `slower_below`.
PackedBrick pack_frame(std::span<const std::byte> brick, std::size_t item_bytes,
                       std::size_t slower_below) {
  // Compression pays if it saves at least a sixteenth.
  std::vector<std::byte> packed =
      frame_of(brick, item_bytes, "lz4", kLz4Level, brick.size() - brick.size() / 16);
  if (packed.empty()) return {BrickCodec::kRaw, {brick.begin(), brick.end()}};
  if (packed.size() < slower_below) {
    std::vector<std::byte> smaller =
        frame_of(brick, item_bytes, "zstd", kZstdLevel, packed.size() - packed.size() / 4);
    if (!smaller.empty()) packed = std::move(smaller);
  }
  packed.shrink_to_fit();
  return {BrickCodec::kBlosc, std::move(packed)};
}

}  // namespace

PackedBrick pack_brick(std::span<const std::byte> brick, std::size_t item_bytes) {
  if (!is_constant(brick, item_bytes)) {
    // The slower compressor makes smooth floats, such as those of labels, much smaller.
    const bool are_floats = item_bytes == sizeof(float);
    return pack_frame(brick, item_bytes, are_floats ? brick.size() / 2 : 0);
  }
  return {BrickCodec::kConstant,
          {brick.begin(), brick.begin() + static_cast<std::ptrdiff_t>(item_bytes)}};
}

// The slower compressor makes error curves much smaller, too.
PackedBrick pack_sized(std::span<const std::byte> bytes) {
  return pack_frame(bytes, 1, bytes.size());
}

std::optional<std::size_t> unpacked_size(BrickCodec codec, std::span<const std::byte> packed) {
  if (codec == BrickCodec::kRaw) return packed.size();
  std::size_t size = 0;
  if (codec != BrickCodec::kBlosc ||
      blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0) {
    return std::nullopt;
  }
  return size;
}

bool unpack_brick(BrickCodec codec, std::span<const std::byte> packed, std::span<std::byte> into) {
  switch (codec) {
    case BrickCodec::kRaw:
      if (packed.size() != into.size()) return false;
      std::copy(packed.begin(), packed.end(), into.begin());
      return true;
    case BrickCodec::kConstant:
      if (packed.empty() || into.size() % packed.size() != 0) return false;
      for (std::size_t at = 0; at < into.size(); at += packed.size()) {
        std::memcpy(into.data() + at, packed.data(), packed.size());
      }
      return true;
    case BrickCodec::kBlosc:
      return unpacked_size(codec, packed) == into.size() &&
             blosc_decompress_ctx(packed.data(), into.data(), into.size(), kOneThread) ==
                 static_cast<int>(into.size());
  }
  return false;
}

}  // namespace multitetra
