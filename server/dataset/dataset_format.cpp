#include "server/dataset/dataset_format.hpp"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "server/dataset/dataset_metadata.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "Numbers and samples are copied as they are in memory.");

constexpr std::string_view kMagic = "\x89MTD\r\n\x1a\n";
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kEntryBytes = 40;
constexpr std::size_t kChecksumBytes = 8;
constexpr std::size_t kNameBytes = 8;
constexpr std::uint64_t kAlignment = 64;
constexpr std::uint32_t kMaxSections = 64;
constexpr std::uint32_t kRequiredFlag = 1;  // A reader that does not know the section gives up.
constexpr std::uint64_t kMaxMetadataBytes = std::uint64_t{1} << 20;
constexpr std::size_t kPortionBytes = std::size_t{1} << 20;

struct Section {
  std::string name;
  std::uint32_t flags = 0;
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
};

using Table = std::vector<Section>;

std::uint64_t aligned(std::uint64_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

std::uint64_t table_end(std::size_t sections) {
  return kHeaderBytes + kEntryBytes * sections + kChecksumBytes;
}

tl::unexpected<Error> damaged(const std::string& section, const std::string& what) {
  return fail(ErrorCode::kDamagedData, "Section \"" + section + "\": " + what);
}

// ---- writing

template <typename Number>
void append(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

void pad(std::string& bytes) { bytes.resize(aligned(bytes.size()), '\0'); }

void append(std::string& bytes, const Section& section) {
  assert(section.name.size() <= kNameBytes);
  bytes += section.name;
  bytes.append(kNameBytes - section.name.size(), '\0');
  append(bytes, section.flags);
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

Result<std::uint32_t> decode_header(std::string_view header, std::uint64_t file_bytes) {
  if (!header.starts_with(kMagic)) {
    return damaged("header", "the first 8 bytes are not those of a prepared dataset (.mtd).");
  }
  const auto version = number_at<std::uint32_t>(header, 8);
  if (version != kDatasetFormatVersion) {
    return fail(ErrorCode::kUnsupportedVersion,
                "Section \"header\": the format version is " + std::to_string(version) +
                    " and this program reads version " + std::to_string(kDatasetFormatVersion) +
                    "; prepare the dataset again or use the program that wrote it.");
  }
  const auto sections = number_at<std::uint32_t>(header, 12);
  if (sections < 1 || sections > kMaxSections) {
    return damaged("header", "it counts " + std::to_string(sections) +
                                 " sections, and a file has 1 to " + std::to_string(kMaxSections) +
                                 ".");
  }
  const auto promised = number_at<std::uint64_t>(header, 16);
  if (promised != file_bytes) {
    return damaged("header", "it promises a file of " + std::to_string(promised) +
                                 " bytes, and there are " + std::to_string(file_bytes) + ".");
  }
  return sections;
}

// Names, flags, and sections that follow each other without overlap up to the end of the file.
Result<Table> decode_entries(std::string_view entries, std::uint64_t begin, std::uint64_t end) {
  Table table;
  for (; !entries.empty(); entries.remove_prefix(kEntryBytes)) {
    const std::string_view padded = entries.substr(0, kNameBytes);
    Section section = {.name = std::string(padded.substr(0, padded.find('\0'))),
                       .flags = number_at<std::uint32_t>(entries, 8),
                       .offset = number_at<std::uint64_t>(entries, 16),
                       .size = number_at<std::uint64_t>(entries, 24),
                       .checksum = number_at<std::uint64_t>(entries, 32)};
    const bool twice = std::any_of(table.begin(), table.end(),
                                   [&](const Section& s) { return s.name == section.name; });
    if (twice) return damaged("table", "it names section \"" + section.name + "\" twice.");
    if (section.offset != aligned(begin)) {
      return damaged("table", "section \"" + section.name + "\" begins at byte " +
                                  std::to_string(section.offset) + " instead of " +
                                  std::to_string(aligned(begin)) + ".");
    }
    if (section.offset > end || section.size > end - section.offset) {
      return damaged("table", "section \"" + section.name + "\" goes beyond the end of the file.");
    }
    begin = section.offset + section.size;
    table.push_back(std::move(section));
  }
  if (begin != end) return damaged("table", "there are bytes after the last section.");
  return table;
}

// The zeros between the table and the sections, and between sections.
Result<Table> with_verified_padding(const ByteSource& source, Table table) {
  std::uint64_t begin = table_end(table.size());
  for (const Section& section : table) {
    const std::string padding = read_text(source, begin, section.offset - begin);
    if (padding.find_first_not_of('\0') != std::string::npos) {
      return damaged(section.name, "the padding before it is not zero.");
    }
    begin = section.offset + section.size;
  }
  return table;
}

Result<Table> decode_table(const ByteSource& source) {
  if (source.size() < kHeaderBytes) {
    return damaged("header", "the file has " + std::to_string(source.size()) +
                                 " bytes, fewer than the header's " + std::to_string(kHeaderBytes) +
                                 ".");
  }
  const auto sections = decode_header(read_text(source, 0, kHeaderBytes), source.size());
  if (!sections) return tl::unexpected(sections.error());
  const std::uint64_t end = table_end(*sections);
  if (end > source.size()) return damaged("table", "the file ends inside it.");

  const std::string bytes = read_text(source, 0, end);
  const std::string_view covered(bytes.data(), bytes.size() - kChecksumBytes);
  if (XXH3_64bits(covered.data(), covered.size()) !=
      number_at<std::uint64_t>(bytes, covered.size())) {
    return damaged("table", "its checksum does not match.");
  }
  auto table = decode_entries(covered.substr(kHeaderBytes), end, source.size());
  if (!table) return table;
  return with_verified_padding(source, *std::move(table));
}

const Section* find(const Table& table, std::string_view name) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const Section& section) { return section.name == name; });
  return found == table.end() ? nullptr : &*found;
}

Result<DatasetMetadata> decode_metadata(const ByteSource& source, const Table& table) {
  const Section* const section = find(table, "metadata");
  if (section == nullptr) return damaged("metadata", "it is missing.");
  if (section->size > kMaxMetadataBytes) {
    return damaged("metadata", "it has " + std::to_string(section->size) + " bytes, more than " +
                                   std::to_string(kMaxMetadataBytes) + ".");
  }
  const std::string text = read_text(source, section->offset, section->size);
  if (XXH3_64bits(text.data(), text.size()) != section->checksum) {
    return damaged("metadata", "its checksum does not match.");
  }
  return parse_metadata(text);
}

template <typename Sample>
std::optional<std::vector<Sample>> read_samples(const ByteSource& source, const Section& section) {
  std::vector<Sample> samples(section.size / sizeof(Sample));
  source.read(section.offset, std::as_writable_bytes(std::span(samples)));
  if (XXH3_64bits(samples.data(), section.size) != section.checksum) return std::nullopt;
  return samples;
}

Result<Samples> decode_samples(const ByteSource& source, const Table& table,
                               const DatasetInfo& info) {
  const Section* const section = find(table, "samples");
  if (section == nullptr) return damaged("samples", "it is missing.");
  std::uint64_t needed = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  for (const std::int32_t side : info.dims) needed *= static_cast<std::uint64_t>(side);
  if (section->size != needed) {
    return damaged("samples", "it has " + std::to_string(section->size) +
                                  " bytes, and the metadata's dims and type need " +
                                  std::to_string(needed) + ".");
  }
  const auto result = [](auto samples) -> Result<Samples> {
    if (!samples) return damaged("samples", "its checksum does not match.");
    return Samples(*std::move(samples));
  };
  switch (info.type) {
    case SampleType::kU8:
      return result(read_samples<std::uint8_t>(source, *section));
    case SampleType::kI8:
      return result(read_samples<std::int8_t>(source, *section));
    case SampleType::kU16:
      return result(read_samples<std::uint16_t>(source, *section));
    case SampleType::kI16:
      return result(read_samples<std::int16_t>(source, *section));
    case SampleType::kF32: {
      auto samples = read_samples<float>(source, *section);
      const auto is_infinite = [](float sample) { return std::isinf(sample); };
      if (samples && std::any_of(samples->begin(), samples->end(), is_infinite)) {
        return damaged("samples", "it has an infinite sample; samples are finite or NaN.");
      }
      return result(std::move(samples));
    }
  }
  return damaged("metadata", "its sample type is not known.");
}

// What is wrong with the sections that this version does not know; nothing when they are whole and
// may be passed over.
std::optional<Error> problem_of_others(const ByteSource& source, const Table& table) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  for (const Section& section : table) {
    if (section.name == "metadata" || section.name == "samples") continue;
    if ((section.flags & kRequiredFlag) != 0) {
      return Error{ErrorCode::kUnsupportedVersion,
                   "Section \"" + section.name +
                       "\": it is required and this program does not know it; use a newer one."};
    }
    XXH3_64bits_reset(state.get());
    for (std::uint64_t done = 0; done < section.size;) {
      const std::uint64_t count = std::min<std::uint64_t>(section.size - done, kPortionBytes);
      const std::string portion = read_text(source, section.offset + done, count);
      XXH3_64bits_update(state.get(), portion.data(), portion.size());
      done += count;
    }
    if (XXH3_64bits_digest(state.get()) != section.checksum) {
      return damaged(section.name, "its checksum does not match.").value();
    }
  }
  return std::nullopt;
}

}  // namespace

std::string encode_head(const DatasetMetadata& metadata, std::span<const std::byte> samples) {
  const std::string text = metadata_text(metadata);
  Section first = {.name = "metadata", .flags = kRequiredFlag, .size = text.size()};
  Section second = {.name = "samples", .flags = kRequiredFlag, .size = samples.size()};
  first.offset = aligned(table_end(2));
  first.checksum = XXH3_64bits(text.data(), text.size());
  second.offset = aligned(first.offset + first.size);
  second.checksum = XXH3_64bits(samples.data(), samples.size());

  std::string bytes(kMagic);
  append(bytes, kDatasetFormatVersion);
  append(bytes, std::uint32_t{2});
  append(bytes, second.offset + second.size);
  append(bytes, first);
  append(bytes, second);
  append(bytes, std::uint64_t{XXH3_64bits(bytes.data(), bytes.size())});
  pad(bytes);
  bytes += text;
  pad(bytes);
  assert(bytes.size() == second.offset);
  return bytes;
}

std::span<const std::byte> sample_bytes(const Samples& samples) {
  return std::visit([](const auto& values) { return std::as_bytes(std::span(values)); }, samples);
}

Result<DatasetMetadata> decode_metadata(const ByteSource& source) {
  const auto table = decode_table(source);
  if (!table) return tl::unexpected(table.error());
  return decode_metadata(source, *table);
}

Result<DecodedDataset> decode_dataset(const ByteSource& source) {
  const auto table = decode_table(source);
  if (!table) return tl::unexpected(table.error());
  if (auto problem = problem_of_others(source, *table)) return tl::unexpected(*problem);
  auto metadata = decode_metadata(source, *table);
  if (!metadata) return tl::unexpected(metadata.error());
  const DatasetInfo& info = metadata->info;
  auto samples = decode_samples(source, *table, info);
  if (!samples) return tl::unexpected(samples.error());
  Dataset dataset = {.info = info,
                     .volume = {.dims = info.dims,
                                .spacing = info.spacing,
                                .index_to_world = info.index_to_world,
                                .samples = *std::move(samples)}};
  return DecodedDataset{*std::move(metadata), std::move(dataset)};
}

}  // namespace multitetra
