// What the sections of a prepared dataset hold, without any I/O. README.md describes every byte.
//
//   samples     the samples, in the bricks of core's BrickLayout, one brick after the other
//   spectrum    the bricks of core's SpectrumLayout, in the order in which they were finished
//   coarse, ranges, bins   what core keeps for a first look; bytes whose meaning only core knows
//   smplsums    the checksum of each brick of samples
//   specidx     place and checksum of each brick of the spectrum
//   metadata    JSON text, see dataset_metadata.hpp
//
// The first two are large and the others small. So a reader verifies all of the structure and the
// small sections when it opens a file, and each brick when it first looks at it.
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
#include "server/dataset/byte_source.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/section_table.hpp"

namespace multitetra {

// The names, in the order in which they are written.
namespace section_names {
inline constexpr const char* kSamples = "samples";
inline constexpr const char* kSpectrum = "spectrum";
inline constexpr const char* kCoarse = "coarse";
inline constexpr const char* kRanges = "ranges";
inline constexpr const char* kBins = "bins";
inline constexpr const char* kSampleChecksums = "smplsums";
inline constexpr const char* kSpectrumIndex = "specidx";
inline constexpr const char* kMetadata = "metadata";
}  // namespace section_names

// One of the names above.
[[nodiscard]] bool is_known_section(std::string_view name);

// A brick as a part of its section. An empty brick is all zero.
struct BrickPlace {
  std::uint64_t offset = 0;  // In the section.
  std::uint32_t size = 0;
  std::uint32_t reserved = 0;  // Zero.
  std::uint64_t checksum = 0;  // XXH3-64 of its bytes.

  friend bool operator==(const BrickPlace&, const BrickPlace&) = default;
};
static_assert(sizeof(BrickPlace) == 24, "The section \"specidx\" is these, one after the other.");

// Everything about a file but the bricks themselves, and where those are.
struct PreparedStructure {
  DatasetMetadata metadata;
  SectionTable sections;  // All of them, with the names above and perhaps others.
  std::vector<std::uint64_t> sample_checksums;  // One for each brick.
  std::vector<BrickPlace> spectrum_index;       // The same; filled bricks tile their section.

  // Requires one of the names above.
  [[nodiscard]] const Section& section(std::string_view name) const;
};

// Verifies everything but the sections "samples" and "spectrum" and those it does not know.
// kDamagedData, with the section and what is wrong, or kUnsupportedVersion. Allocates in proportion
// to the size of the source at most: 8 bytes for a brick of samples, 24 for one of the spectrum.
[[nodiscard]] Result<PreparedStructure> decode_structure(const ByteSource& source);

// DatasetInfo::content_id of what has these sections.
[[nodiscard]] std::uint64_t content_id_of(const SectionTable& sections);

// The section "specidx" from its bytes: kDamagedData when an entry is not what it must be, or the
// bricks do not fill the section "spectrum".
[[nodiscard]] Result<std::vector<BrickPlace>> decode_spectrum_index(
    std::span<const std::byte> bytes, std::size_t bricks, std::uint64_t spectrum_bytes);

// Where brick `index` of the samples is in their section.
[[nodiscard]] BrickPlace sample_brick_place(const PreparedStructure& structure,
                                            const BrickLayout& layout, std::size_t index);

// What is wrong with the bytes of a brick of the section: they do not have their checksum, or
// samples of `type` are infinite. `type` is none in the spectrum.
[[nodiscard]] Result<void> check_brick(const std::string& section, std::size_t index,
                                       std::span<const std::byte> bytes, std::uint64_t checksum,
                                       std::optional<SampleType> type);

// The places of the bricks that are not empty, in the order of the file; nullopt when they overlap
// or leave gaps in a section of this size.
[[nodiscard]] std::optional<std::vector<std::size_t>> bricks_in_file_order(
    std::span<const BrickPlace> index, std::uint64_t section_size);

}  // namespace multitetra
