// The contents of the sections of a prepared dataset, without I/O. FORMAT.md describes every byte.
//
//   metadata   JSON text, see dataset_metadata.hpp
//   bins       the edges of the isovalue bins
//   specidx    size, codec and checksum of each brick of the spectrum, in the order of the file
//   coarse     every eighth sample, packed
//   ranges     least and largest sample of each cell, packed
//   spectrum   the packed bricks of core's SpectrumLayout, from the coarsest level to the finest
//   samples    the packed bricks of core's BrickLayout, in Morton order
//   smplidx    size, codec and checksum of each brick of samples, in the order of the file
//
// A file whose metadata states that its errors are missing has neither "specidx" nor "spectrum".
// Sections needed to open a file and to make the first preview come first. Small sections are
// verified when they are read, bricks when they are unpacked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/brick_codec.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/section_table.hpp"

namespace multitetra {

// Names of the sections, in the order of the file.
namespace section_names {
inline constexpr const char* kMetadata = "metadata";
inline constexpr const char* kBins = "bins";
inline constexpr const char* kSpectrumIndex = "specidx";
inline constexpr const char* kCoarse = "coarse";
inline constexpr const char* kRanges = "ranges";
inline constexpr const char* kSpectrum = "spectrum";
inline constexpr const char* kSamples = "samples";
inline constexpr const char* kSampleIndex = "smplidx";
}  // namespace section_names

// Returns whether `name` is one of the names above.
[[nodiscard]] bool is_known_section(std::string_view name);

// An entry of "specidx" and "smplidx". Bricks are stored in the order of the entries, each at the
// next multiple of kBrickAlignment.
struct BrickEntry {
  std::uint32_t size_and_codec = 0;  // Codec in the highest four bits.
  std::uint32_t checksum = 0;        // Lower half of the XXH3-64 of the packed bytes.

  friend bool operator==(const BrickEntry&, const BrickEntry&) = default;
};
static_assert(sizeof(BrickEntry) == 8);
inline constexpr std::uint64_t kBrickAlignment = 4;
inline constexpr std::uint32_t kMaxPackedBytes = (std::uint32_t{1} << 28) - 1;

[[nodiscard]] inline std::uint32_t size_with_codec(std::size_t size, BrickCodec codec) {
  return static_cast<std::uint32_t>(size) | static_cast<std::uint32_t>(codec) << 28;
}
[[nodiscard]] std::uint32_t brick_checksum(std::span<const std::byte> packed);
[[nodiscard]] constexpr std::uint64_t brick_begin(std::uint64_t end_of_the_one_before) {
  return (end_of_the_one_before + kBrickAlignment - 1) / kBrickAlignment * kBrickAlignment;
}

// The location of a packed brick within its section.
struct BrickPlace {
  std::uint64_t offset = 0;
  std::uint32_t size_and_codec = 0;
  std::uint32_t checksum = 0;

  [[nodiscard]] std::uint32_t size() const { return size_and_codec & kMaxPackedBytes; }
  [[nodiscard]] BrickCodec codec() const { return static_cast<BrickCodec>(size_and_codec >> 28); }
};

// All of a file but the bricks, and their locations.
struct PreparedStructure {
  DatasetMetadata metadata;
  SectionTable sections;  // All sections, including unknown ones.
  std::vector<std::byte> bins;
  std::vector<BrickPlace> spectrum_index;  // Indexed by brick; empty without errors.

  [[nodiscard]] bool has_errors() const { return metadata.info.missing.empty(); }
  // Requires one of the names above that the file has.
  [[nodiscard]] const Section& section(std::string_view name) const;
};

// Verifies header, table, metadata, bins and the spectrum index; for a local source also the
// checksums of the other small sections. Returns kInvalidArgument for other files, kDamagedData,
// with the section and the problem, or kUnsupportedVersion. Allocates at most in proportion to the
// size of the source.
[[nodiscard]] Result<PreparedStructure> decode_structure(const ByteSource& source);

// Returns the index of the samples by brick; it takes 16 bytes of memory per brick.
[[nodiscard]] Result<std::vector<BrickPlace>> decode_sample_index(
    const ByteSource& source, const PreparedStructure& structure);

// Unpacks the section "coarse" or "ranges" to `bytes` bytes. Checks `bytes` against the size of the
// section before it allocates memory.
[[nodiscard]] Result<std::vector<std::byte>> read_packed_section(const ByteSource& source,
                                                                 const Section& section,
                                                                 std::uint64_t bytes);
// Return the unpacked sizes of "coarse" and "ranges" in bytes.
[[nodiscard]] std::uint64_t coarse_bytes(const DatasetInfo& info);
[[nodiscard]] std::uint64_t ranges_bytes(const DatasetInfo& info);

// Returns the DatasetInfo::content_id of a file with these sections.
[[nodiscard]] std::uint64_t content_id_of(const SectionTable& sections);

// Returns the maximum size of a brick of the spectrum.
[[nodiscard]] std::size_t max_spectrum_brick_bytes();

// Unpacks a brick whose checksum was verified. Bricks of samples need `type` and their unpacked
// size in `bytes`; bricks of the spectrum have no type and contain their size. Returns kDamagedData
// if the brick cannot be unpacked, has a different size, or has infinite samples.
[[nodiscard]] Result<void> unpack_checked(const std::string& section, std::size_t index,
                                          const BrickPlace& place,
                                          std::span<const std::byte> packed,
                                          std::optional<SampleType> type, std::size_t bytes,
                                          std::vector<std::byte>& into);

}  // namespace multitetra
