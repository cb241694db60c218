// Packed bytes to plain ones. What comes in is untrusted: the length that must come out is known
// beforehand, and nothing beyond it is kept.
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

// kDeflate is the stream inside zip files, without the frame of zlib. kLz4 is a bare block,
// kSizedLz4 one behind its unpacked size in four bytes, as numcodecs writes it.
enum class Packing { kNone, kGzip, kZlib, kDeflate, kZstd, kBlosc, kBzip2, kLz4, kSizedLz4, kHex };

// The packing that arrays call by this name (Zarr and N5: "gzip", "zlib", "zstd", "blosc", "bz2",
// "bzip2", "lz4" (kSizedLz4), "raw"); nullopt for others.
[[nodiscard]] std::optional<Packing> packing_from(std::string_view name);

// Exactly into.size() bytes from all of `packed`. kDamagedData when the packed bytes are damaged,
// end early, hold another number of bytes, or have something behind their end. Not for kHex.
[[nodiscard]] Result<void> unpack(Packing packing, std::span<const std::byte> packed,
                                  std::span<std::byte> into);

// The same when only a bound is known: at most `most` bytes.
[[nodiscard]] Result<std::vector<std::byte>> unpack_at_most(Packing packing,
                                                            std::span<const std::byte> packed,
                                                            std::size_t most);

// A stream (gzip with all its members, zlib, deflate, bzip2, or pairs of hexadecimal digits with
// white space between) in a file from `offset` on, read forwards.
class UnpackedStream {
 public:
  // The packing of the bytes at `offset`, by what they begin with; kNone when they are none of
  // kGzip, kZlib, kBzip2.
  [[nodiscard]] static Packing packing_at(const InputFile& file, std::uint64_t offset);

  // Requires packing kGzip, kZlib, kDeflate, kBzip2 or kHex.
  UnpackedStream(const InputFile& file, std::uint64_t offset, Packing packing);
  ~UnpackedStream();

  // The next bytes of the stream; fewer when it ends. Throws VolumeFileError when the stream is
  // damaged, the file ends inside it, or something other than zeros lies behind it.
  std::size_t read_some(std::span<std::byte> into);
  // Unpacks what is left, so that all checksums are compared. Throws as read_some does.
  void require_good_end();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multitetra
