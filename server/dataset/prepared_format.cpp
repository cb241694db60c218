#include "server/dataset/prepared_format.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/mesh/checksum.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/dataset/brick_order.hpp"
#include "server/dataset/detail/packed_bytes.hpp"

namespace multitetra {
namespace {

using namespace section_names;

constexpr std::uint64_t kMaxMetadataBytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kMaxBinsBytes = sizeof(float) * (IsovalueBins::kMaxCount + 1);
constexpr std::array<const char*, 8> kKnownSections = {
    kMetadata, kBins, kSpectrumIndex, kCoarse, kSpectrum, kRanges, kSamples, kSampleIndex};

bool is_of_errors(std::string_view name) { return name == kSpectrumIndex || name == kSpectrum; }

// Checks that all known sections exist, those of the errors apart, and that unknown ones are
// optional.
Result<void> check_names(const SectionTable& sections) {
  for (const char* const name : kKnownSections) {
    if (find_section(sections, name) == nullptr && !is_of_errors(name)) {
      return damaged(name, "it is missing.");
    }
  }
  for (const Section& section : sections) {
    if (is_known_section(section.name) || !section.required) continue;
    return fail(
        ErrorCode::kUnsupportedVersion,
        "Section \"" + section.name + "\": it is unknown to this program. Use a newer program.");
  }
  return {};
}

// Checks that the sections of the errors exist exactly if the metadata says so.
Result<void> check_errors(const PreparedStructure& structure) {
  for (const char* const name : {kSpectrumIndex, kSpectrum}) {
    const bool exists = find_section(structure.sections, name) != nullptr;
    if (exists && !structure.has_errors()) {
      return damaged(name, "it is there, although the metadata says that errors are missing.");
    }
    if (!exists && structure.has_errors()) return damaged(name, "it is missing.");
  }
  return {};
}

Result<DatasetMetadata> decode_metadata(const ByteSource& source, const Section& section) {
  if (section.size > kMaxMetadataBytes) {
    return damaged(kMetadata, "it has " + std::to_string(section.size) + " bytes, more than " +
                                  std::to_string(kMaxMetadataBytes) + ".");
  }
  std::string text(section.size, '\0');
  if (const auto checked = read_section(source, section, std::as_writable_bytes(std::span(text)));
      !checked) {
    return tl::unexpected(checked.error());
  }
  auto metadata = parse_metadata(text);
  if (!metadata) {
    return fail(metadata.error().code, metadata.error().text + " Prepare the dataset again.");
  }
  return metadata;
}

Result<void> check_size(const Section& section, std::uint64_t needed) {
  if (section.size == needed) return {};
  return damaged(section.name, "it has " + std::to_string(section.size) +
                                   " bytes; the metadata requires " + std::to_string(needed) + ".");
}

// Reads the index of a section whose bricks are stored in the order of `layout`.
template <typename Layout>
Result<std::vector<BrickPlace>> decode_index(const ByteSource& source, const Section& index,
                                             const Section& bricks, const Layout& layout) {
  const std::size_t count = layout.size();
  if (const auto checked = check_size(index, std::uint64_t{count} * sizeof(BrickEntry)); !checked)
    return tl::unexpected(checked.error());
  std::vector<BrickEntry> entries(count);
  if (const auto read = read_section(source, index, std::as_writable_bytes(std::span(entries)));
      !read) {
    return tl::unexpected(read.error());
  }
  std::vector<BrickPlace> places(count);
  std::uint64_t end = 0;
  std::size_t next = 0;
  in_file_order(layout, [&](std::size_t brick) {
    const BrickEntry& entry = entries[next++];
    places[brick] = {.offset = brick_begin(end),
                     .size_and_codec = entry.size_and_codec,
                     .checksum = entry.checksum};
    end = places[brick].offset + places[brick].size();
  });
  if (end == bricks.size) return places;
  return damaged(index.name, "its bricks do not fill section \"" + bricks.name + "\".");
}

bool has_infinite(std::span<const std::byte> floats) {
  for (; floats.size() >= sizeof(float); floats = floats.subspan(sizeof(float))) {
    float sample = 0;
    std::memcpy(&sample, floats.data(), sizeof(float));
    if (std::isinf(sample)) return true;
  }
  return false;
}

}  // namespace

bool is_known_section(std::string_view name) {
  return std::find(kKnownSections.begin(), kKnownSections.end(), name) != kKnownSections.end();
}

const Section& PreparedStructure::section(std::string_view name) const {
  const Section* const found = find_section(sections, name);
  assert(found != nullptr);
  return *found;
}

std::uint32_t brick_checksum(std::span<const std::byte> packed) {
  return static_cast<std::uint32_t>(checksum(packed));
}

Result<PreparedStructure> decode_structure(const ByteSource& source) {
  auto sections = decode_section_table(source);
  if (!sections) return tl::unexpected(sections.error());
  if (const auto checked = check_names(*sections); !checked) return tl::unexpected(checked.error());

  PreparedStructure structure;
  structure.sections = *std::move(sections);
  auto metadata = decode_metadata(source, structure.section(kMetadata));
  if (!metadata) return tl::unexpected(metadata.error());
  structure.metadata = *std::move(metadata);
  if (const auto checked = check_errors(structure); !checked) {
    return tl::unexpected(checked.error());
  }
  // From here on, sizes in the metadata are checked against the size of the file.
  const std::size_t bricks = BrickLayout(structure.metadata.info.dims).size();
  if (const auto checked =
          check_size(structure.section(kSampleIndex), std::uint64_t{bricks} * sizeof(BrickEntry));
      !checked) {
    return tl::unexpected(checked.error());
  }
  const Section& bins = structure.section(kBins);
  if (bins.size > kMaxBinsBytes) return damaged(kBins, "it has too many bins.");
  structure.bins.resize(static_cast<std::size_t>(bins.size));
  if (const auto read = read_section(source, bins, structure.bins); !read) {
    return tl::unexpected(read.error());
  }
  if (structure.has_errors()) {
    auto index =
        decode_index(source, structure.section(kSpectrumIndex), structure.section(kSpectrum),
                     SpectrumLayout(structure.metadata.info));
    if (!index) return tl::unexpected(index.error());
    structure.spectrum_index = *std::move(index);
  }
  if (source.is_remote()) return structure;
  for (const char* const small : {kCoarse, kRanges}) {
    if (const auto checked = check_section(source, structure.section(small)); !checked) {
      return tl::unexpected(checked.error());
    }
  }
  return structure;
}

Result<std::vector<BrickPlace>> decode_sample_index(const ByteSource& source,
                                                    const PreparedStructure& structure) {
  auto index = decode_index(source, structure.section(kSampleIndex), structure.section(kSamples),
                            BrickLayout(structure.metadata.info.dims));
  const auto is_empty = [](const BrickPlace& place) { return place.size() == 0; };
  if (!index || std::none_of(index->begin(), index->end(), is_empty)) return index;
  return damaged(kSampleIndex, "a brick of samples is empty.");
}

Result<std::vector<std::byte>> read_packed_section(const ByteSource& source, const Section& section,
                                                   std::uint64_t bytes) {
  // Each piece has a header of 4 bytes, and packing never enlarges it.
  const std::uint64_t pieces = (bytes + kPieceBytes - 1) / kPieceBytes;
  if (section.size < pieces * sizeof(std::uint32_t) || section.size > bytes + 4 * pieces) {
    return damaged(section.name, "it has " + std::to_string(section.size) +
                                     " bytes, which cannot contain the " + std::to_string(bytes) +
                                     " bytes that the metadata requires.");
  }
  std::vector<std::byte> packed(static_cast<std::size_t>(section.size));
  if (const auto read = read_section(source, section, packed); !read) {
    return tl::unexpected(read.error());
  }
  std::vector<std::byte> unpacked(static_cast<std::size_t>(bytes));
  if (const auto whole = unpack_bytes(section.name.c_str(), packed, unpacked); !whole) {
    return tl::unexpected(whole.error());
  }
  return unpacked;
}

std::uint64_t coarse_bytes(const DatasetInfo& info) {
  return static_cast<std::uint64_t>(bytes_per_sample(info.type)) * coarse_extent(info).size();
}

std::uint64_t ranges_bytes(const DatasetInfo& info) {
  return 2 * static_cast<std::uint64_t>(bytes_per_sample(info.type)) * cell_extent(info).size();
}

std::uint64_t content_id_of(const SectionTable& sections) {
  const bool has_errors = find_section(sections, kSpectrum) != nullptr;
  const std::array<std::uint64_t, 5> identity = {
      kPreparedFormatVersion, find_section(sections, kMetadata)->checksum,
      find_section(sections, kSamples)->checksum, find_section(sections, kSampleIndex)->checksum,
      has_errors ? find_section(sections, kBins)->checksum : 0};
  return checksum(std::as_bytes(std::span(identity)));
}

std::size_t max_spectrum_brick_bytes() {
  constexpr std::size_t kPlane = 8 * sizeof(std::uint64_t) + 3 * SpectrumLayout::kPoints;
  return 4 + IsovalueBins::kMaxCount * (sizeof(std::uint32_t) + kPlane);
}

Result<void> unpack_checked(const std::string& section, std::size_t index, const BrickPlace& place,
                            std::span<const std::byte> packed, std::optional<SampleType> type,
                            std::size_t bytes, std::vector<std::byte>& into) {
  const std::string brick = "brick " + std::to_string(index) + ": ";
  if (brick_checksum(packed) != place.checksum) {
    return damaged(section, brick + "its checksum does not match.");
  }
  if (!type) {
    const auto size = unpacked_size(place.codec(), packed);
    if (!size || *size > max_spectrum_brick_bytes()) {
      return damaged(section, brick + "it cannot be decompressed.");
    }
    bytes = *size;
  }
  // A constant brick consists of one sample.
  const bool is_possible = !type || place.codec() != BrickCodec::kConstant ||
                           packed.size() == static_cast<std::size_t>(bytes_per_sample(*type));
  into.resize(bytes);
  if (!is_possible || !unpack_brick(place.codec(), packed, into)) {
    return damaged(section, brick + "it cannot be decompressed.");
  }
  if (type == SampleType::kF32 && has_infinite(into)) {
    return damaged(section, brick + "it has an infinite sample; samples must be finite or NaN.");
  }
  return {};
}

}  // namespace multitetra
