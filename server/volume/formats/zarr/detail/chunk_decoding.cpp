// Decodes the stored bytes of chunks.
#include <boost/crc.hpp>

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/zarr/detail/chunked_array.hpp"

namespace multitetra {
namespace {

using Crc32c = boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true>;

Result<std::span<const std::byte>> checked_crc(std::span<const std::byte> bytes) {
  std::uint32_t stored = 0;
  if (bytes.size() < sizeof(stored)) return fail(ErrorCode::kDamagedData, "it ends too early");
  const auto body = bytes.first(bytes.size() - sizeof(stored));
  std::memcpy(&stored, bytes.data() + body.size(), sizeof(stored));
  Crc32c crc;
  crc.process_bytes(body.data(), body.size());
  if (stored != crc.checksum())
    return fail(ErrorCode::kDamagedData, "its checksum (CRC-32C) does not match");
  return body;
}

// Applies all codecs to `stored`. Returns exactly `size` bytes.
Result<std::vector<std::byte>> decoded(const std::vector<ChunkCodec>& codecs,
                                       std::span<const std::byte> stored, std::size_t size) {
  std::vector<std::byte> bytes;
  std::size_t unpackings = 0;
  for (const ChunkCodec& codec : codecs) unpackings += codec.kind == ChunkCodec::Kind::kUnpack;
  for (const ChunkCodec& codec : codecs) {
    if (codec.kind == ChunkCodec::Kind::kCheckCrc32c) {
      auto body = checked_crc(stored);
      if (!body) return tl::unexpected(body.error());
      stored = *body;
      continue;
    }
    // Intermediate results are compressed themselves and may be slightly longer.
    const std::size_t most = --unpackings == 0 ? size : size + size / 8 + 4096;
    auto unpacked = unpack_at_most(codec.packing, stored, most);
    if (!unpacked) return tl::unexpected(unpacked.error());
    bytes = *std::move(unpacked);
    stored = bytes;
  }
  if (stored.size() != size) {
    return fail(ErrorCode::kDamagedData, "it has " + std::to_string(stored.size()) +
                                             " bytes instead of " + std::to_string(size));
  }
  if (bytes.size() == size && stored.data() == bytes.data()) return bytes;
  return std::vector<std::byte>(stored.begin(), stored.end());
}

std::size_t stored_bytes(const ArrayLayout& layout) {
  return layout.chunk_bytes() / bytes_of(layout.type) * layout.stored_width();
}

std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (const std::byte byte : bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return value;
}

std::vector<std::byte> filled(const ArrayLayout& layout) {
  std::vector<std::byte> bytes(layout.chunk_bytes());
  // Halves are filled with zeros: only N5 has short blocks, and no other fill value.
  if (layout.are_halves) {
    bytes.resize(bytes.size() / 2);
    return bytes;
  }
  for (std::size_t at = 0; at < bytes.size(); at += layout.fill.size()) {
    std::copy(layout.fill.begin(), layout.fill.end(),
              bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return bytes;
}

// Decodes an N5 block: mode (2 bytes), number of dimensions (2), the shape, fastest first (4 each),
// all big-endian, then the packed numbers of that shape.
Result<std::vector<std::byte>> decode_block(const ArrayLayout& layout,
                                            std::span<const std::byte> stored) {
  const std::size_t dimensions = layout.shape.size();
  const std::size_t head_bytes = 4 + 4 * dimensions;
  const auto damaged = [](const char* what) { return fail(ErrorCode::kDamagedData, what); };
  if (stored.size() < head_bytes) return damaged("it ends within its header");
  if (big_endian(stored.first(2)) != 0) return damaged("it is not a block of the default mode");
  if (big_endian(stored.subspan(2, 2)) != dimensions)
    return damaged("its number of dimensions differs from the array's");
  std::vector<std::size_t> shape(dimensions);
  std::size_t size = layout.stored_width();
  for (std::size_t i = 0; i < dimensions; ++i) {
    const std::size_t d = dimensions - 1 - i;
    shape[d] = big_endian(stored.subspan(4 + 4 * i, 4));
    if (shape[d] == 0 || shape[d] > static_cast<std::size_t>(layout.chunk[d])) {
      return damaged("its shape is larger than the block size");
    }
    size *= shape[d];
  }
  auto numbers = decoded(layout.codecs, stored.subspan(head_bytes), size);
  if (!numbers || size == stored_bytes(layout)) return numbers;
  std::vector<std::byte> chunk = filled(layout);
  const std::size_t row = shape.back() * layout.stored_width();
  std::vector<std::size_t> at(dimensions, 0);
  for (std::size_t from = 0; from < size; from += row) {
    std::size_t to = 0;
    for (std::size_t d = 0; d < dimensions; ++d) {
      to = to * static_cast<std::size_t>(layout.chunk[d]) + at[d];
    }
    std::memcpy(chunk.data() + to * layout.stored_width(), numbers->data() + from, row);
    for (std::size_t d = dimensions - 1; d-- > 0;) {
      if (++at[d] < shape[d]) break;
      at[d] = 0;
    }
  }
  return chunk;
}

}  // namespace

Result<std::vector<std::byte>> decode_chunk(const ArrayLayout& layout,
                                            std::span<const std::byte> stored) {
  auto chunk = layout.has_block_headers ? decode_block(layout, stored)
                                        : decoded(layout.codecs, stored, stored_bytes(layout));
  if (chunk) to_host_order(*chunk, layout.stored_width(), layout.endian);
  if (chunk && layout.are_halves) return floats_from_halves(*chunk);
  return chunk;
}

std::size_t shard_index_bytes(const ArrayLayout& layout) {
  std::size_t bytes = sizeof(ShardEntry);
  for (const std::int64_t count : layout.shards->chunk_counts)
    bytes *= static_cast<std::size_t>(count);
  return bytes + 4 * layout.shards->index_codecs.size();  // Each codec adds a CRC.
}

Result<std::vector<ShardEntry>> decode_shard_index(const ArrayLayout& layout,
                                                   std::span<const std::byte> stored) {
  const std::size_t size = shard_index_bytes(layout) - 4 * layout.shards->index_codecs.size();
  const auto bytes = decoded(layout.shards->index_codecs, stored, size);
  if (!bytes) return tl::unexpected(bytes.error());
  std::vector<ShardEntry> entries(size / sizeof(ShardEntry));
  std::memcpy(entries.data(), bytes->data(), size);
  return entries;
}

}  // namespace multitetra
