// Samples that lie in files as they are, not written as text: in one file or several, where they
// can be read anywhere without reading what comes before them; or in one file, packed as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "server/dataset/formats/endian.hpp"
#include "server/dataset/formats/input_file.hpp"

namespace multitetra {

// A run of samples: the bytes of `file` from `offset` on.
struct PayloadPart {
  std::filesystem::path file;
  std::uint64_t offset = 0;
};

// One part after the other is the volume, x fastest. All parts have the same number of bytes.
struct PlainPayload {
  std::vector<PayloadPart> parts;
  std::uint64_t part_bytes = 0;
  Endian endian = Endian::kLittle;
  // Given: the one part is the beginning of a stream (gzip, zlib, bzip2), and the samples begin so
  // many unpacked bytes behind it.
  std::optional<std::uint64_t> unpacked_offset = std::nullopt;
};

// Reads bytes anywhere in a payload that is not packed. At most one of its files is open at a time.
class PayloadReader {
 public:
  // Throws VolumeFileError when a part is missing or its file ends before the part does.
  explicit PayloadReader(PlainPayload payload);
  ~PayloadReader();
  PayloadReader(PayloadReader&&) noexcept;

  // The bytes first ... first + count - 1 of the payload, numbers of `width` bytes in the byte
  // order of this machine. Requires that they are in the payload, `first` and `count` multiples of
  // width. Throws VolumeFileError.
  void read(std::uint64_t first, std::uint64_t count, std::size_t width, std::byte* into);

 private:
  PlainPayload payload_;
  std::size_t open_part_ = 0;  // The part that `open_file_` belongs to.
  std::unique_ptr<InputFile> open_file_;
};

}  // namespace multitetra
