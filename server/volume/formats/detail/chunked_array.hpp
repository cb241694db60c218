// An n-dimensional array that is stored in chunks: what the metadata of Zarr 2, Zarr 3 and N5 say,
// in one form. The readers of the metadata are strict: what is not understood is refused by name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Decoding steps of a chunk's bytes, in this order.
struct ChunkCodec {
  enum class Kind { kUnpack, kCheckCrc32c };
  Kind kind = Kind::kUnpack;
  Packing packing = Packing::kNone;
};

// A shard is a stored object that holds many chunks, and an index of where they are.
struct ShardLayout {
  std::vector<std::int64_t> chunk_counts;  // Along each dimension of a shard.
  std::vector<ChunkCodec> index_codecs;
  bool index_at_end = true;
};

// Dimensions are in the order of C arrays: the last one varies fastest, unless `order` differs.
struct ArrayLayout {
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> chunk;  // The shape of a chunk; inside shards, of an inner one.
  // The order of the bytes in a chunk: dimensions, slowest first.
  std::vector<std::size_t> order;
  StoredType type = StoredType::kU8;
  bool are_halves = false;  // Stored are floats of 16 bits; `type` is what they become, kF32.
  Endian endian = Endian::kLittle;
  std::vector<std::byte> fill;  // One number in host order: what missing chunks hold.
  std::vector<ChunkCodec> codecs;
  std::optional<ShardLayout> shards;
  std::string key_prefix;  // The prefix of the keys of chunks: "c/", or empty.
  char key_separator = '.';
  bool key_is_reversed = false;  // The fastest dimension's number comes first (N5).
  // N5: each chunk contains its own shape.
  bool has_block_headers = false;
  std::vector<std::string> dimension_names;  // Empty, or one for each dimension.

  // The size of a decoded chunk in `type`, and of a chunk as it is stored behind the codecs.
  [[nodiscard]] std::size_t chunk_bytes() const;
  [[nodiscard]] std::size_t stored_width() const { return are_halves ? 2 : bytes_of(type); }
  // The key of the stored object (shard or chunk) with these numbers.
  [[nodiscard]] std::string key(const std::vector<std::int64_t>& object) const;
};

// Parse `.zarray`, `zarr.json` (of an array) and `attributes.json`. kInvalidArgument or
// kDamagedData with a sentence otherwise.
[[nodiscard]] Result<ArrayLayout> parse_zarr_2(std::string_view text);
[[nodiscard]] Result<ArrayLayout> parse_zarr_3(std::string_view text);
[[nodiscard]] Result<ArrayLayout> parse_n5(std::string_view text);

// The numbers of one chunk, chunk_bytes() of them in the chunk's own order, in the byte order of
// this machine. What a short N5 block leaves out is the fill value.
[[nodiscard]] Result<std::vector<std::byte>> decode_chunk(const ArrayLayout& layout,
                                                          std::span<const std::byte> stored);

// Where the chunks of a shard are: offset and length each, kNoChunk twice for a missing one.
inline constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};
struct ShardEntry {
  std::uint64_t offset = kNoChunk;
  std::uint64_t length = kNoChunk;
};
// The stored size of a shard's index in bytes. Requires layout.shards.
[[nodiscard]] std::size_t shard_index_bytes(const ArrayLayout& layout);
[[nodiscard]] Result<std::vector<ShardEntry>> decode_shard_index(const ArrayLayout& layout,
                                                                 std::span<const std::byte> stored);

}  // namespace multitetra
