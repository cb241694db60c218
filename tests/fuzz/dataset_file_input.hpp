// Converts fuzzer input to a prepared dataset. Raw input would hardly ever have valid checksums,
// and would never get past the table.
//
// The first byte selects:
//   'f'   a file without the zeros at the end of its head: the first kShortHead bytes, then the bytes
//         from 4096 on; the table's checksum is corrected
//   else  sections, each preceded by its length in two bytes, of an otherwise valid file, including
//         the checksums of bricks
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "common/mesh/checksum.hpp"
#include "server/dataset/prepared_format.hpp"
#include "tests/support/memory_source.hpp"

namespace multitetra {

inline constexpr std::size_t kShortHead = 24 + 40 * 8 + 8;
inline constexpr std::array<const char*, 8> kFuzzedSections = {
    section_names::kMetadata, section_names::kBins,       section_names::kSpectrumIndex,
    section_names::kCoarse,   section_names::kSpectrum,   section_names::kRanges,
    section_names::kSamples,  section_names::kSampleIndex};

inline void mend_table_checksum(std::string& file) {
  if (file.size() < kHeadBytes) return;
  std::uint32_t sections = 0;
  std::memcpy(&sections, file.data() + 12, sizeof(sections));
  const std::size_t covered = 24 + 40 * std::min<std::size_t>(sections, kMaxSections);
  const std::uint64_t sum = checksum(std::as_bytes(std::span(file).first(covered)));
  std::memcpy(file.data() + covered, &sum, sizeof(sum));
}

inline std::string file_of_bytes(std::string_view input) {
  std::string file(input.substr(0, kShortHead));
  if (input.size() <= kShortHead) return file;
  file.resize(kHeadBytes, '\0');
  file += input.substr(kShortHead);
  mend_table_checksum(file);
  return file;
}

// Removes the next section from `input` and returns it.
inline std::string_view take_section(std::string_view& input) {
  std::uint16_t size = 0;
  if (input.size() < sizeof(size)) return {};
  std::memcpy(&size, input.data(), sizeof(size));
  input.remove_prefix(sizeof(size));
  const std::string_view section = input.substr(0, size);
  input.remove_prefix(section.size());
  return section;
}

// Corrects the checksums in an index, as far as its bricks lie in their section.
inline void mend_brick_checksums(std::string& index, std::string_view bricks) {
  std::uint64_t end = 0;
  for (std::size_t at = 0; at + sizeof(BrickEntry) <= index.size(); at += sizeof(BrickEntry)) {
    BrickEntry entry;
    std::memcpy(&entry, index.data() + at, sizeof(entry));
    const BrickPlace place{.offset = brick_begin(end), .size_and_codec = entry.size_and_codec};
    end = place.offset + place.size();
    if (end > bricks.size()) return;
    entry.checksum =
        brick_checksum(std::as_bytes(std::span(bricks)).subspan(place.offset, place.size()));
    std::memcpy(index.data() + at, &entry, sizeof(entry));
  }
}

// Without errors, the sections of the spectrum are left out.
inline std::string file_of_sections(std::string_view input, bool has_errors) {
  std::array<std::string, kFuzzedSections.size()> sections;
  for (std::string& section : sections) section = take_section(input);
  mend_brick_checksums(sections[2], sections[4]);
  mend_brick_checksums(sections[7], sections[6]);
  SectionTable table;
  std::string file(kHeadBytes, '\0');
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const char* const name = kFuzzedSections[i];
    const std::string& section = sections[i];
    if (!has_errors && (i == 2 || i == 4)) continue;
    file.resize(section_begin(file.size()), '\0');
    table.push_back({.name = name,
                     .offset = file.size(),
                     .size = section.size(),
                     .checksum = checksum(std::as_bytes(std::span(section)))});
    file += section;
  }
  return file.replace(0, kHeadBytes, encode_head(table));
}

inline std::string dataset_file_of(std::string_view input) {
  if (input.empty()) return {};
  const std::string_view rest = input.substr(1);
  return input[0] == 'f' ? file_of_bytes(rest) : file_of_sections(rest, input[0] != 'e');
}

// ---- inputs that represent a whole file

inline std::string input_of_bytes(std::string_view file) {
  return "f" + std::string(file.substr(0, kShortHead)) + std::string(file.substr(kHeadBytes));
}

// Requires a file with the sections above, those of the spectrum excepted.
inline std::string input_of_sections(std::string_view file) {
  const auto table = decode_section_table(MemorySource(std::as_bytes(std::span(file))));
  std::string input = find_section(*table, section_names::kSpectrum) ? "s" : "e";
  for (const char* const name : kFuzzedSections) {
    const Section* const section = find_section(*table, name);
    const auto size = static_cast<std::uint16_t>(section ? section->size : 0);
    input.append(reinterpret_cast<const char*>(&size), sizeof(size));
    if (section) input += file.substr(section->offset, section->size);
  }
  return input;
}

}  // namespace multitetra
