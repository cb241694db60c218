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
std::optional<Error> problem_of_names(const SectionTable& sections) {
  for (const char* const name : kKnownSections) {
    if (find_section(sections, name) == nullptr) return damage(name, "it is missing.");
  }
  for (const Section& section : sections) {
    if (is_known_section(section.name) || !section.required) continue;
    return Error{ErrorCode::kUnsupportedVersion,
                 "Section \"" + section.name +
                     "\": it is required and this program does not know it. Use a newer one."};
  }
  return std::nullopt;
}

Result<DatasetMetadata> decode_metadata(const ByteSource& source, const Section& section) {
  if (section.size > kMaxMetadataBytes) {
    return tl::unexpected(damage(kMetadata, "it has " + std::to_string(section.size) +
                                                " bytes, more than " +
                                                std::to_string(kMaxMetadataBytes) + "."));
  }
  std::string text(section.size, '\0');
  if (auto problem = read_section(source, section, std::as_writable_bytes(std::span(text)))) {
    return tl::unexpected(*std::move(problem));
  }
  auto metadata = parse_metadata(text);
  if (!metadata) {
    return fail(metadata.error().code, metadata.error().text + " Prepare the dataset again.");
  }
  return metadata;
}

std::optional<Error> problem_of_size(const Section& section, std::uint64_t needed) {
  if (section.size == needed) return std::nullopt;
  return damage(section.name, "it has " + std::to_string(section.size) +
                                  " bytes, and what the metadata says needs " +
                                  std::to_string(needed) + ".");
}

// Reads a section of `count` items that follow each other. Returns what is wrong with it.
template <typename Item>
std::optional<Error> read_items(const ByteSource& source, const Section& section, std::size_t count,
                                std::vector<Item>& items) {
  if (auto problem = problem_of_size(section, std::uint64_t{count} * sizeof(Item))) return problem;
  items.resize(count);
  return read_section(source, section, std::as_writable_bytes(std::span(items)));
}

std::optional<Error> problem_of_index(std::span<const BrickPlace> index,
                                      std::uint64_t section_size) {
  for (std::size_t i = 0; i < index.size(); ++i) {
    const bool is_whole = index[i].size != 0 || index[i] == BrickPlace{};
    if (is_whole && index[i].reserved == 0) continue;
    return damage(kSpectrumIndex,
                  "the entry of brick " + std::to_string(i) + " is not zero where it must be.");
  }
  if (bricks_in_file_order(index, section_size)) return std::nullopt;
  return damage(kSpectrumIndex, "its bricks overlap, or do not fill section \"spectrum\".");
}

// Fills what depends on the metadata. Returns what is wrong with it.
std::optional<Error> decode_indexes(const ByteSource& source, PreparedStructure& structure) {
  const DatasetInfo& info = structure.metadata.info;
  std::uint64_t bytes = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  for (const std::int32_t side : info.dims) bytes *= static_cast<std::uint64_t>(side);
  if (auto problem = problem_of_size(structure.section(kSamples), bytes)) return problem;
  if (auto problem = read_items(source, structure.section(kSampleChecksums),
                                BrickLayout(info.dims).size(), structure.sample_checksums)) {
    return problem;
  }
  if (auto problem = read_items(source, structure.section(kSpectrumIndex),
                                SpectrumLayout(info).size(), structure.spectrum_index)) {
    return problem;
  }
  return problem_of_index(structure.spectrum_index, structure.section(kSpectrum).size);
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
  if (auto problem = problem_of_names(*sections)) return tl::unexpected(*std::move(problem));

  PreparedStructure structure;
  structure.sections = *std::move(sections);
  auto metadata = decode_metadata(source, structure.section(kMetadata));
  if (!metadata) return tl::unexpected(metadata.error());
  structure.metadata = *std::move(metadata);
  if (auto problem = decode_indexes(source, structure)) return tl::unexpected(*std::move(problem));
  for (const char* const small : {kCoarse, kRanges, kBins}) {
    if (auto problem = damage_of(source, structure.section(small))) {
      return tl::unexpected(*std::move(problem));
    }
  }
  return structure;
}

BrickPlace sample_brick_place(const PreparedStructure& structure, const BrickLayout& layout,
                              std::size_t index) {
  const auto width = static_cast<std::uint32_t>(bytes_per_sample(structure.metadata.info.type));
  const GridCounts brick = layout.at(index);
  return {.offset = layout.offset(brick) * width,
          .size = static_cast<std::uint32_t>(layout.volume(brick)) * width,
          .checksum = structure.sample_checksums[index]};
}

std::optional<Error> damage_of_brick(const std::string& section, std::size_t index,
                                     std::span<const std::byte> bytes, std::uint64_t expected,
                                     std::optional<SampleType> type) {
  const std::string brick = "brick " + std::to_string(index) + ": ";
  if (checksum(bytes) != expected) return damage(section, brick + "its checksum does not match.");
  if (type == SampleType::kF32 && has_infinite(bytes)) {
    return damage(section, brick + "it has an infinite sample; samples are finite or NaN.");
  }
  return std::nullopt;
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
