// Samples that a file has one after the other from some place on: as they are, or packed as a
// whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/dataset/formats/endian.hpp"
#include "server/dataset/formats/stored_volume.hpp"

namespace multitetra {

// The slices of `header` from `offset` of the file on. Read when asked for, in any order. Throws
// VolumeFileError when the file is too short.
[[nodiscard]] std::unique_ptr<StoredSlices> plain_slices(const std::filesystem::path& file,
                                                         std::uint64_t offset, Endian endian,
                                                         const ImageHeader& header);

// The same where what `offset` counts are the unpacked bytes of a stream (gzip, zlib or bzip2) that
// begins at `packed_offset` of the file. Slices are unpacked in order and nothing is kept: going
// back begins anew.
[[nodiscard]] std::unique_ptr<StoredSlices> packed_slices(const std::filesystem::path& file,
                                                          std::uint64_t packed_offset,
                                                          std::uint64_t offset, Endian endian,
                                                          const ImageHeader& header);

// Whichever of the two it is, by what the file begins with.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_file(const std::filesystem::path& file,
                                                           std::uint64_t offset, Endian endian,
                                                           const ImageHeader& header);

}  // namespace multitetra
