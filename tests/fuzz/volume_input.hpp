// What the harnesses of volume files have in common.
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"
#include "tests/fuzz/require.hpp"

namespace multitetra {

inline std::string gzipped(std::string_view bytes) {
  z_stream stream{};
  require(deflateInit2(&stream, 1, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, bytes.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  require(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

// Requires that the slices can be read in any order, each the same alone as among all. Throws
// VolumeFileError where the volume is refused.
inline void read_in_any_order(const StoredVolume& volume) {
  constexpr std::int64_t kMaxBytes = 1 << 20;  // Larger volumes only cost time here.
  const ImageHeader& header = volume.header;
  check_header("fuzzed", header);
  const std::size_t slice = header.slice_bytes();
  if (slice > kMaxBytes || header.dims[2] > kMaxBytes / static_cast<std::int64_t>(slice)) return;
  const auto slices = static_cast<std::size_t>(header.dims[2]);
  std::vector<std::byte> all(slices * slice);
  volume.slices->read(0, slices, all.data());
  std::vector<std::byte> one(slice);
  for (std::size_t i = std::min<std::size_t>(slices, 8); i-- > 0;) {
    volume.slices->read(i, 1, one.data());
    require(std::equal(one.begin(), one.end(), all.data() + i * slice));
  }
}

}  // namespace multitetra
