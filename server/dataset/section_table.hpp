// The container of a prepared dataset (.mtd): named sections of bytes with checksums.
// prepared_format.hpp describes the contents of the sections; FORMAT.md describes every byte.
//
//   0        24                24 + 40 n     + 8      4096
//   +--------+-----------------+-------------+--------+-----------+-------+-----------+----
//   | header | table, n entries| its checksum| zeros  | section 0 | zeros | section 1 | ...
//   +--------+-----------------+-------------+--------+-----------+-------+-----------+----
//
// Numbers are little-endian, checksums are XXH3-64. The first section begins at byte 4096, the
// others at the next multiple of 64; the last one ends the file. Every byte is verified: by the
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
  std::string name;      // 1 to 8 ASCII bytes, unique in a file.
  bool required = true;  // Readers that do not know the section must refuse the file.
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;  // XXH3-64 of the section's bytes.

  friend bool operator==(const Section&, const Section&) = default;
};

using SectionTable = std::vector<Section>;  // In the order of the file.

// Returns the offset of a section after others that end at this offset; kHeadBytes for the first.
[[nodiscard]] std::uint64_t section_begin(std::uint64_t end_of_those_before);

// Returns the first kHeadBytes of a file. Requires 1 to kMaxSections sections at the offsets that
// section_begin() returns.
[[nodiscard]] std::string encode_head(const SectionTable& sections);

// Verifies the header, the table and, for a local source, the zeros between sections; reads no
// section. Returns kInvalidArgument for other files, else kDamagedData or kUnsupportedVersion.
[[nodiscard]] Result<SectionTable> decode_section_table(const ByteSource& source);

// Checks the zeros between sections.
[[nodiscard]] Result<void> check_padding(const ByteSource& source, const SectionTable& table);

// Returns the section of this name, or null.
[[nodiscard]] const Section* find_section(const SectionTable& sections, std::string_view name);

// Checks a section's checksum, in little memory for a section of any size.
[[nodiscard]] Result<void> check_section(const ByteSource& source, const Section& section);

// Reads a whole section and checks it; fetches a damaged one of a remote file once more. Requires
// into.size() == section.size.
[[nodiscard]] Result<void> read_section(const ByteSource& source, const Section& section,
                                        std::span<std::byte> into);

// Returns whether `bytes` begin a dataset of any version; the first kMagicBytes suffice.
inline constexpr std::size_t kMagicBytes = 8;
[[nodiscard]] bool begins_as_dataset(std::span<const std::byte> bytes);
// Returns the same for a file; false if it cannot be read.
[[nodiscard]] bool begins_as_dataset(const std::filesystem::path& file);

// Returns kDamagedData with the section, the problem and the remedy.
[[nodiscard]] tl::unexpected<Error> damaged(std::string_view section, std::string_view what);

}  // namespace multitetra
