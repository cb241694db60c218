// An n-dimensional array stored in chunks: the metadata of Zarr 2, Zarr 3 and N5 in a common form.
// The parsers are strict: they reject by name whatever they do not support.
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

// A step in decoding the bytes of a chunk.
struct ChunkCodec {
  enum class Kind { kUnpack, kCheckCrc32c };
  Kind kind = Kind::kUnpack;
  Packing packing = Packing::kNone;
};

// A shard is a stored object with many chunks, and an index of their locations.
struct ShardLayout {
  std::vector<std::int64_t> chunk_counts;  // Along each dimension of a shard.
  std::vector<ChunkCodec> index_codecs;
  bool index_at_end = true;
};

// Dimensions are in C order, the last one fastest, unless `order` differs.
struct ArrayLayout {
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> chunk;  // The shape of a chunk; with shards, of an inner chunk.
  // The order of numbers in a chunk: dimensions, slowest first.
  std::vector<std::size_t> order;
  StoredType type = StoredType::kU8;
  bool are_halves = false;  // Stored as 16-bit floats; `type` is kF32.
  Endian endian = Endian::kLittle;
  std::vector<std::byte> fill;  // The value of missing chunks: one number in host order.
  // In Zarr 2: it is a number other than 0, which xarray understands as that of missing samples.
  bool fill_is_missing = false;
  std::vector<ChunkCodec> codecs;
  std::optional<ShardLayout> shards;
  std::string key_prefix;  // Prefix of chunk keys: "c/" or empty.
  char key_separator = '.';
  // The fastest dimension comes first (N5).
  bool key_is_reversed = false;
  // Each chunk contains its own shape (N5).
  bool has_block_headers = false;
  std::vector<std::string> dimension_names;  // Empty, or one per dimension.

  // Size of a decoded chunk in `type`, and of a number as stored.
  [[nodiscard]] std::size_t chunk_bytes() const;
  [[nodiscard]] std::size_t stored_width() const { return are_halves ? 2 : bytes_of(type); }
  // Returns the key of the stored object (shard or chunk) with these indices.
  [[nodiscard]] std::string key(const std::vector<std::int64_t>& object) const;
};

// Parse `.zarray`, `zarr.json` (of an array) and `attributes.json`. Return kInvalidArgument or
// kDamagedData with a sentence on failure.
[[nodiscard]] Result<ArrayLayout> parse_zarr_2(std::string_view text);
[[nodiscard]] Result<ArrayLayout> parse_zarr_3(std::string_view text);
[[nodiscard]] Result<ArrayLayout> parse_n5(std::string_view text);

// Returns the chunk_bytes() bytes of a chunk in its own order, in host byte order. Numbers missing
// from a short N5 block have the fill value.
[[nodiscard]] Result<std::vector<std::byte>> decode_chunk(const ArrayLayout& layout,
                                                          std::span<const std::byte> stored);

// The location of a chunk in its shard; offset and length are kNoChunk if it is missing.
inline constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};
struct ShardEntry {
  std::uint64_t offset = kNoChunk;
  std::uint64_t length = kNoChunk;
};
// Returns the stored size of a shard's index in bytes. Requires layout.shards.
[[nodiscard]] std::size_t shard_index_bytes(const ArrayLayout& layout);
[[nodiscard]] Result<std::vector<ShardEntry>> decode_shard_index(const ArrayLayout& layout,
                                                                 std::span<const std::byte> stored);

}  // namespace multitetra
