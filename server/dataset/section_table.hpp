// The frame of a prepared dataset (.mtd): named sections of bytes, and what proves them whole. What
// the sections hold is in prepared_format.hpp; FORMAT.md describes every byte.
//
//   0        24                24 + 40 n     + 8      4096
//   +--------+-----------------+-------------+--------+-----------+-------+-----------+----
//   | header | table, n entries| its checksum| zeros  | section 0 | zeros | section 1 | ...
//   +--------+-----------------+-------------+--------+-----------+-------+-----------+----
//
// Numbers are little-endian, checksums are XXH3-64. The first section begins at byte 4096, the
// others at the next multiple of 64; the last one ends the file. Every byte is covered: by the
// magic, the table's checksum, a section's checksum, or as zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {

inline constexpr std::uint32_t kPreparedFormatVersion = 1;
inline constexpr std::uint64_t kHeadBytes = 4096;  // Header, table and zeros.
inline constexpr std::size_t kMaxSections = 64;
static_assert(24 + 40 * kMaxSections + 8 <= kHeadBytes);

struct Section {
  std::string name;      // ASCII, 1 to 8 bytes, unique in a file.
  bool required = true;  // A reader that does not know the section must refuse the file.
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;  // XXH3-64 of its bytes.

  friend bool operator==(const Section&, const Section&) = default;
};

using SectionTable = std::vector<Section>;  // In the order of the file.

// The offset of a section when those before it end here; kHeadBytes for the first.
[[nodiscard]] std::uint64_t section_begin(std::uint64_t end_of_those_before);

// The first kHeadBytes of a file. Requires 1 to kMaxSections sections that begin at the places that
// section_begin returns.
[[nodiscard]] std::string encode_head(const SectionTable& sections);

// Verifies header, table and, of a source on this machine, the zeros between sections; no section
// is read. kDamagedData or kUnsupportedVersion.
[[nodiscard]] Result<SectionTable> decode_section_table(const ByteSource& source);

// The zeros between sections.
[[nodiscard]] Result<void> check_padding(const ByteSource& source, const SectionTable& table);

// The section of this name; null when there is none.
[[nodiscard]] const Section* find_section(const SectionTable& sections, std::string_view name);

// The damage of a section's bytes; none when their checksum matches. Needs little
// memory for a section of any size.
[[nodiscard]] Result<void> check_section(const ByteSource& source, const Section& section);

// The whole section. Requires into.size() == section.size. Returns what is wrong with it.
[[nodiscard]] Result<void> read_section(const ByteSource& source, const Section& section,
                                        std::span<std::byte> into);

// Whether these are the first bytes of a dataset of any version; kMagicBytes of them are enough.
inline constexpr std::size_t kMagicBytes = 8;
[[nodiscard]] bool begins_as_dataset(std::span<const std::byte> bytes);
// The same of a file; no if it cannot be read.
[[nodiscard]] bool begins_as_dataset(const std::filesystem::path& file);

// kDamagedData: the section, what is wrong with it, and what to do.
[[nodiscard]] tl::unexpected<Error> damaged(std::string_view section, std::string_view what);

}  // namespace multitetra
