#include "server/dataset/prepared_format.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/checksum.hpp"

namespace multitetra {
namespace {

using namespace section_names;

constexpr std::uint64_t kMaxMetadataBytes = std::uint64_t{1} << 20;
constexpr std::array<const char*, 8> kKnownSections = {
    kSamples, kSpectrum, kCoarse, kRanges, kBins, kSampleChecksums, kSpectrumIndex, kMetadata};

// All known sections are there, and those that are not known may be passed over.
Result<void> check_names(const SectionTable& sections) {
  for (const char* const name : kKnownSections) {
    if (find_section(sections, name) == nullptr) return damaged(name, "it is missing.");
  }
  for (const Section& section : sections) {
    if (is_known_section(section.name) || !section.required) continue;
    return fail(ErrorCode::kUnsupportedVersion,
                "Section \"" + section.name +
                    "\": it is required and this program does not know it. Use a newer one.");
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
                                   " bytes, and what the metadata says needs " +
                                   std::to_string(needed) + ".");
}

// Reads a section of `count` items that follow each other. Returns what is wrong with it.
template <typename Item>
Result<void> read_items(const ByteSource& source, const Section& section, std::size_t count,
                        std::vector<Item>& items) {
  if (auto checked = check_size(section, std::uint64_t{count} * sizeof(Item)); !checked)
    return checked;
  items.resize(count);
  return read_section(source, section, std::as_writable_bytes(std::span(items)));
}

Result<void> check_index(std::span<const BrickPlace> index, std::uint64_t section_size) {
  for (std::size_t i = 0; i < index.size(); ++i) {
    const bool is_whole = index[i].size != 0 || index[i] == BrickPlace{};
    if (is_whole && index[i].reserved == 0) continue;
    return damaged(kSpectrumIndex,
                   "the entry of brick " + std::to_string(i) + " is not zero where it must be.");
  }
  if (bricks_in_file_order(index, section_size)) return {};
  return damaged(kSpectrumIndex, "its bricks overlap, or do not fill section \"spectrum\".");
}

// Fills what depends on the metadata. Returns what is wrong with it.
Result<void> decode_indexes(const ByteSource& source, PreparedStructure& structure) {
  const DatasetInfo& info = structure.metadata.info;
  std::uint64_t bytes = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  for (const std::int32_t side : info.dims) bytes *= static_cast<std::uint64_t>(side);
  if (auto checked = check_size(structure.section(kSamples), bytes); !checked) return checked;
  if (auto checked = read_items(source, structure.section(kSampleChecksums),
                                BrickLayout(info.dims).size(), structure.sample_checksums);
      !checked) {
    return checked;
  }
  if (auto checked = read_items(source, structure.section(kSpectrumIndex),
                                SpectrumLayout(info).size(), structure.spectrum_index);
      !checked) {
    return checked;
  }
  return check_index(structure.spectrum_index, structure.section(kSpectrum).size);
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

Result<PreparedStructure> decode_structure(const ByteSource& source) {
  auto sections = decode_section_table(source);
  if (!sections) return tl::unexpected(sections.error());
  if (const auto checked = check_names(*sections); !checked) return tl::unexpected(checked.error());

  PreparedStructure structure;
  structure.sections = *std::move(sections);
  auto metadata = decode_metadata(source, structure.section(kMetadata));
  if (!metadata) return tl::unexpected(metadata.error());
  structure.metadata = *std::move(metadata);
  if (const auto checked = decode_indexes(source, structure); !checked)
    return tl::unexpected(checked.error());
  for (const char* const small : {kCoarse, kRanges, kBins}) {
    if (const auto checked = check_section(source, structure.section(small)); !checked) {
      return tl::unexpected(checked.error());
    }
  }
  return structure;
}

std::uint64_t content_id_of(const SectionTable& sections) {
  const std::array<std::uint64_t, 3> identity = {kPreparedFormatVersion,
                                                 find_section(sections, kSampleChecksums)->checksum,
                                                 find_section(sections, kBins)->checksum};
  return checksum(std::as_bytes(std::span(identity)));
}

Result<std::vector<BrickPlace>> decode_spectrum_index(std::span<const std::byte> bytes,
                                                      std::size_t bricks,
                                                      std::uint64_t spectrum_bytes) {
  if (bytes.size() != bricks * sizeof(BrickPlace)) {
    return damaged(kSpectrumIndex, "it has " + std::to_string(bytes.size()) +
                                       " bytes, and what the metadata says needs " +
                                       std::to_string(bricks * sizeof(BrickPlace)) + ".");
  }
  std::vector<BrickPlace> index(bricks);
  if (!bytes.empty()) std::memcpy(index.data(), bytes.data(), bytes.size());
  if (const auto checked = check_index(index, spectrum_bytes); !checked) {
    return tl::unexpected(checked.error());
  }
  return index;
}

BrickPlace sample_brick_place(const PreparedStructure& structure, const BrickLayout& layout,
                              std::size_t index) {
  const auto width = static_cast<std::uint32_t>(bytes_per_sample(structure.metadata.info.type));
  const GridCounts brick = layout.at(index);
  return {.offset = layout.offset(brick) * width,
          .size = static_cast<std::uint32_t>(layout.volume(brick)) * width,
          .checksum = structure.sample_checksums[index]};
}

Result<void> check_brick(const std::string& section, std::size_t index,
                         std::span<const std::byte> bytes, std::uint64_t expected,
                         std::optional<SampleType> type) {
  const std::string brick = "brick " + std::to_string(index) + ": ";
  if (checksum(bytes) != expected) return damaged(section, brick + "its checksum does not match.");
  if (type == SampleType::kF32 && has_infinite(bytes)) {
    return damaged(section, brick + "it has an infinite sample; samples are finite or NaN.");
  }
  return {};
}

std::optional<std::vector<std::size_t>> bricks_in_file_order(std::span<const BrickPlace> index,
                                                             std::uint64_t section_size) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i].size != 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return index[a].offset < index[b].offset; });
  std::uint64_t end = 0;
  for (const std::size_t i : order) {
    if (index[i].offset != end) return std::nullopt;
    end += index[i].size;
  }
  if (end != section_size) return std::nullopt;
  return order;
}

}  // namespace multitetra
