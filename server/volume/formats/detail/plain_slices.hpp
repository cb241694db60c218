// Samples stored contiguously, uncompressed or compressed as a whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// A file with some or all of the samples.
struct SamplePart {
  std::filesystem::path file;
  std::uint64_t offset = 0;          // Start of the samples, or of the stream that contains them.
  Packing packing = Packing::kNone;  // kGzip, kZlib, kBzip2 or kHex for a stream.
  std::uint64_t skipped = 0;         // Unpacked bytes of a stream before the samples.
};

// Samples divided into parts of equal size.
struct SampleParts {
  std::vector<SamplePart> parts = {};
  std::uint64_t part_bytes = 0;
  // Offset of the first slice, counted over all parts.
  std::uint64_t first_byte = 0;
  Endian endian = Endian::kLittle;
  // Bytes that belong behind each part. A finding reports more; absent if anything may follow.
  std::optional<std::uint64_t> known_behind = std::nullopt;
};

// Returns the slices of `header`, readable in any order. Streams are unpacked forward without a
// cache: going back starts over. Throws VolumeFileError if an uncompressed file is too short.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_parts(SampleParts samples,
                                                            const ImageHeader& header);

// Returns the slices of `header` that start at `offset` in a file.
[[nodiscard]] std::unique_ptr<StoredSlices> plain_slices(const std::filesystem::path& file,
                                                         std::uint64_t offset, Endian endian,
                                                         const ImageHeader& header);

// Returns the same for a file that may be a gzip or bzip2 stream, recognized by its first bytes;
// `offset` counts unpacked bytes.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_file(
    const std::filesystem::path& file, std::uint64_t offset, Endian endian,
    const ImageHeader& header, std::optional<std::uint64_t> known_behind = std::nullopt);

// Returns the slices of a volume whose components are stored as separate volumes. `header`
// describes samples with all components.
[[nodiscard]] std::unique_ptr<StoredSlices> interleaved_slices(
    std::vector<std::unique_ptr<StoredSlices>> components, const ImageHeader& header);

// Returns slices of `numbers` numbers of `type` each as f32, by a slope and an intercept each.
[[nodiscard]] std::unique_ptr<StoredSlices> scaled_slices(
    std::unique_ptr<StoredSlices> stored, StoredType type, std::size_t numbers,
    std::vector<std::array<double, 2>> scales);

}  // namespace multitetra
