// Samples that files have one after the other as bytes: as they are, or packed as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// A file with some of the samples, or with all of them.
struct SamplePart {
  std::filesystem::path file;
  std::uint64_t offset = 0;          // Where the samples begin, or the stream that packs them.
  Packing packing = Packing::kNone;  // kGzip, kZlib, kBzip2 or kHex: a stream.
  std::uint64_t skipped = 0;         // Unpacked bytes of a stream before the samples.
};

// Samples that are cut into parts of equally many bytes.
struct SampleParts {
  std::vector<SamplePart> parts = {};
  std::uint64_t part_bytes = 0;
  // Where the first slice begins, counted over all parts.
  std::uint64_t first_byte = 0;
  Endian endian = Endian::kLittle;
};

// The slices of `header`, in any order. A stream is unpacked forwards and nothing is kept: going
// back starts over. Throws VolumeFileError when a file that is not packed is too short.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_parts(SampleParts samples,
                                                            const ImageHeader& header);

// The slices of `header` from `offset` of one file on.
[[nodiscard]] std::unique_ptr<StoredSlices> plain_slices(const std::filesystem::path& file,
                                                         std::uint64_t offset, Endian endian,
                                                         const ImageHeader& header);

// The same in a file that may be packed by gzip or bzip2 as a whole, recognized by its first bytes;
// `offset` counts unpacked bytes.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_file(const std::filesystem::path& file,
                                                           std::uint64_t offset, Endian endian,
                                                           const ImageHeader& header);

// The slices of a volume each of whose components is stored as a volume of its own. `header` is
// that of the samples with all of them.
[[nodiscard]] std::unique_ptr<StoredSlices> interleaved_slices(
    std::vector<std::unique_ptr<StoredSlices>> components, const ImageHeader& header);

}  // namespace multitetra
