#include "server/dataset/section_table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <utility>

#include "common/base/open_file.hpp"
#include "common/mesh/checksum.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "Numbers and samples are copied as they are in memory.");

constexpr std::string_view kMagic = "\x89MTD1\r\n\x1a";
static_assert(kMagic.size() == kMagicBytes);
constexpr std::string_view kMagicOf0 = "\x89MTD\r\n\x1a\n";  // Signature of releases 0.x.
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kEntryBytes = 40;
constexpr std::size_t kNameBytes = 8;
constexpr std::uint64_t kAlignment = 64;
constexpr std::uint32_t kRequiredFlag = 1;
constexpr std::size_t kPortionBytes = std::size_t{1} << 20;

// ---- writing

template <typename Number>
void append(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

void append(std::string& bytes, const Section& section) {
  assert(!section.name.empty() && section.name.size() <= kNameBytes);
  bytes += section.name;
  bytes.append(kNameBytes - section.name.size(), '\0');
  append(bytes, section.required ? kRequiredFlag : 0U);
  append(bytes, std::uint32_t{0});
  append(bytes, section.offset);
  append(bytes, section.size);
  append(bytes, section.checksum);
}

// ---- reading

template <typename Number>
Number number_at(std::string_view bytes, std::size_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

std::string read_text(const ByteSource& source, std::uint64_t offset, std::uint64_t size) {
  std::string bytes(size, '\0');
  source.read(offset, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

Result<void> check_version(std::uint32_t version) {
  if (version == kPreparedFormatVersion) return {};
  return fail(ErrorCode::kUnsupportedVersion,
              "It has format version " + std::to_string(version) + "; this program reads version " +
                  std::to_string(kPreparedFormatVersion) +
                  ". Use a newer program or prepare the dataset again.");
}

// Returns the number of sections. Checks the magic and the version before the rest.
Result<std::uint32_t> decode_header(std::string_view header, std::uint64_t file_bytes) {
  if (header.starts_with(kMagicOf0)) {
    return fail(ErrorCode::kUnsupportedVersion,
                "It was written by release 0.x of this program, and its format is no longer "
                "supported: prepare the dataset again.");
  }
  if (!header.starts_with(kMagic)) {
    return fail(ErrorCode::kInvalidArgument, "It is not a prepared dataset (.mtd).");
  }
  if (header.size() < kHeaderBytes) return damaged("header", "the file ends inside it.");
  if (const auto checked = check_version(number_at<std::uint32_t>(header, 8)); !checked) {
    return tl::unexpected(checked.error());
  }
  const auto sections = number_at<std::uint32_t>(header, 12);
  if (sections < 1 || sections > kMaxSections) {
    return damaged("header", "it counts " + std::to_string(sections) +
                                 " sections; a file must have 1 to " +
                                 std::to_string(kMaxSections) + ".");
  }
  const auto promised = number_at<std::uint64_t>(header, 16);
  if (promised != file_bytes) {
    return damaged("header", "it declares a file of " + std::to_string(promised) +
                                 " bytes, but the file has " + std::to_string(file_bytes) + ".");
  }
  if (file_bytes < kHeadBytes) return damaged("table", "the file ends inside it.");
  return sections;
}

// Requires kEntryBytes bytes.
Result<Section> decode_entry(std::string_view entry) {
  const std::string_view padded = entry.substr(0, kNameBytes);
  const std::string_view name = padded.substr(0, padded.find('\0'));
  const auto is_printable = [](char c) { return c > ' ' && c <= '~'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), is_printable) ||
      padded.find_first_not_of('\0', name.size()) != std::string_view::npos) {
    return damaged("table", "the name of a section is not 1 to 8 letters, padded with zeros.");
  }
  const auto flags = number_at<std::uint32_t>(entry, 8);
  if ((flags & ~kRequiredFlag) != 0 || number_at<std::uint32_t>(entry, 12) != 0) {
    return damaged("table", "section \"" + std::string(name) + "\" has unknown flags.");
  }
  return Section{.name = std::string(name),
                 .required = flags == kRequiredFlag,
                 .offset = number_at<std::uint64_t>(entry, 16),
                 .size = number_at<std::uint64_t>(entry, 24),
                 .checksum = number_at<std::uint64_t>(entry, 32)};
}

// Checks the location of a section; the sections before it end at `end_before`.
Result<void> check_place(const Section& section, std::uint64_t end_before,
                         std::uint64_t file_bytes) {
  const std::string quoted = "section \"" + section.name + "\" ";
  const std::uint64_t begin = section_begin(end_before);
  if (section.offset != begin) {
    return damaged("table", quoted + "begins at byte " + std::to_string(section.offset) +
                                " instead of " + std::to_string(begin) + ".");
  }
  if (begin > file_bytes || section.size > file_bytes - begin) {
    return damaged("table", quoted + "ends beyond the end of the file.");
  }
  return {};
}

// Decodes the entries; sections must follow each other without overlap up to the end of the file.
Result<SectionTable> decode_entries(std::string_view entries, std::uint64_t file_bytes) {
  SectionTable table;
  std::uint64_t end = 0;
  for (; !entries.empty(); entries.remove_prefix(kEntryBytes)) {
    auto section = decode_entry(entries.substr(0, kEntryBytes));
    if (!section) return tl::unexpected(section.error());
    if (find_section(table, section->name) != nullptr) {
      return damaged("table", "it lists section \"" + section->name + "\" twice.");
    }
    if (const auto checked = check_place(*section, end, file_bytes); !checked) {
      return tl::unexpected(checked.error());
    }
    end = section->offset + section->size;
    table.push_back(*std::move(section));
  }
  if (end != file_bytes) return damaged("table", "the file has bytes after the last section.");
  return table;
}

}  // namespace

tl::unexpected<Error> damaged(std::string_view section, std::string_view what) {
  return fail(ErrorCode::kDamagedData, "Section \"" + std::string(section) + "\": " +
                                           std::string(what) + " Prepare the dataset again.");
}

std::uint64_t section_begin(std::uint64_t end_of_those_before) {
  return std::max(kHeadBytes, (end_of_those_before + kAlignment - 1) / kAlignment * kAlignment);
}

std::string encode_head(const SectionTable& sections) {
  assert(!sections.empty() && sections.size() <= kMaxSections);
  std::string bytes(kMagic);
  append(bytes, kPreparedFormatVersion);
  append(bytes, static_cast<std::uint32_t>(sections.size()));
  append(bytes, sections.back().offset + sections.back().size);
  for (const Section& section : sections) append(bytes, section);
  append(bytes, checksum(std::as_bytes(std::span(bytes))));
  bytes.resize(kHeadBytes, '\0');
  return bytes;
}

Result<SectionTable> decode_section_table(const ByteSource& source) {
  const std::string head = read_text(source, 0, std::min(source.size(), kHeadBytes));
  const auto sections = decode_header(head, source.size());
  if (!sections) return tl::unexpected(sections.error());
  const std::size_t covered = kHeaderBytes + kEntryBytes * *sections;
  if (checksum(std::as_bytes(std::span(head).first(covered))) !=
      number_at<std::uint64_t>(head, covered)) {
    return damaged("table", "its checksum does not match.");
  }
  const std::string_view entries(head.data() + kHeaderBytes, covered - kHeaderBytes);
  auto table = decode_entries(entries, source.size());
  if (!table) return table;
  if (head.find_first_not_of('\0', covered + 8) != std::string::npos) {
    return damaged("table", "the padding after it is not zero.");
  }
  if (source.is_remote()) return table;
  if (const auto checked = check_padding(source, *table); !checked) {
    return tl::unexpected(checked.error());
  }
  return table;
}

Result<void> check_padding(const ByteSource& source, const SectionTable& table) {
  for (std::size_t i = 1; i < table.size(); ++i) {
    const std::uint64_t end = table[i - 1].offset + table[i - 1].size;
    const std::string padding = read_text(source, end, table[i].offset - end);
    if (padding.find_first_not_of('\0') != std::string::npos) {
      return damaged(table[i].name, "the padding before it is not zero.");
    }
  }
  return {};
}

const Section* find_section(const SectionTable& sections, std::string_view name) {
  const auto found = std::find_if(sections.begin(), sections.end(),
                                  [&](const Section& section) { return section.name == name; });
  return found == sections.end() ? nullptr : &*found;
}

Result<void> check_section(const ByteSource& source, const Section& section) {
  RunningChecksum sum;
  std::vector<std::byte> portion(std::min<std::uint64_t>(section.size, kPortionBytes));
  for (std::uint64_t done = 0; done < section.size;) {
    const auto count = std::min<std::uint64_t>(section.size - done, portion.size());
    source.read(section.offset + done, std::span(portion).first(count));
    sum.add(std::span(portion).first(count));
    done += count;
  }
  if (sum.value() == section.checksum) return {};
  return damaged(section.name, "its checksum does not match.");
}

Result<void> read_section(const ByteSource& source, const Section& section,
                          std::span<std::byte> into) {
  assert(into.size() == section.size);
  for (int attempt = 0;; ++attempt) {
    source.read(section.offset, into);
    if (checksum(into) == section.checksum) return {};
    if (!source.is_remote() || attempt > 0) break;
    source.invalidate({.offset = section.offset, .size = section.size});
  }
  return damaged(section.name, "its checksum does not match.");
}

bool begins_as_dataset(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with(kMagic) || text.starts_with(kMagicOf0);
}

bool begins_as_dataset(const std::filesystem::path& file) {
  const auto begin = OpenFile(file).content(kMagicBytes);
  return begin && begins_as_dataset(std::as_bytes(std::span(*begin)));
}

}  // namespace multitetra
