// Decompresses untrusted bytes. The unpacked length is known in advance, and no more is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// kDeflate is a raw stream as in zip files, without zlib's frame. kLz4 is a bare block; kSizedLz4
// is a block after its unpacked size in four bytes, as numcodecs writes it.
enum class Packing { kNone, kGzip, kZlib, kDeflate, kZstd, kBlosc, kBzip2, kLz4, kSizedLz4, kHex };

// Parses the names in Zarr and N5 metadata ("gzip", "zlib", "zstd", "blosc", "bz2", "bzip2", "lz4"
// (kSizedLz4), "raw"); returns nullopt for others.
[[nodiscard]] std::optional<Packing> packing_from(std::string_view name);

// Unpacks all of `packed` to exactly into.size() bytes. Returns kDamagedData if the bytes are
// damaged, truncated, of a different size, or followed by others. Not for kHex.
[[nodiscard]] Result<void> unpack(Packing packing, std::span<const std::byte> packed,
                                  std::span<std::byte> into);

// Unpacks at most `most` bytes, if the size is not known.
[[nodiscard]] Result<std::vector<std::byte>> unpack_at_most(Packing packing,
                                                            std::span<const std::byte> packed,
                                                            std::size_t most);

// Reads a stream in a file forward from `offset`: gzip with all its members, zlib, deflate, bzip2,
// or pairs of hexadecimal digits with optional white space.
class UnpackedStream {
 public:
  // Recognizes the packing at `offset` by its first bytes; kNone unless kGzip, kZlib or kBzip2.
  [[nodiscard]] static Packing packing_at(const InputFile& file, std::uint64_t offset);

  // Requires kGzip, kZlib, kDeflate, kBzip2 or kHex.
  UnpackedStream(const InputFile& file, std::uint64_t offset, Packing packing);
  ~UnpackedStream();

  // Reads the next bytes; fewer at the end. Throws VolumeFileError if the stream is damaged or
  // truncated, or anything but zeros follows it (eight bytes may, of kDeflate).
  std::size_t read_some(std::span<std::byte> into);
  // Unpacks the rest to verify all checksums; returns its length. Throws as read_some() does.
  std::uint64_t require_good_end();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multitetra
