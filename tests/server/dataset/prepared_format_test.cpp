#include "server/dataset/prepared_format.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/checksum.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "tests/support/memory_source.hpp"
#include "tests/support/prepared_example.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using testing::expect_contains;

std::string encoded(const PreparedExample& example) {
  const TemporaryFolder folder;
  write_prepared(folder.path() / "a.mtd", example);
  return bytes_of_file(folder.path() / "a.mtd");
}

Result<PreparedStructure> structure_of(std::string_view file) {
  return decode_structure(MemorySource(bytes_of(file)));
}

std::string error_in_structure(std::string_view file) {
  const auto structure = structure_of(file);
  return structure ? "whole" : structure.error().text;
}

std::string error_in_bytes(std::string_view file) {
  const auto verified = verify_bytes(MemorySource(bytes_of(file)));
  return verified ? "whole" : verified.error().text;
}

// Opens the file, reads every brick, and expects either the example's data or an error.
void expect_nothing_wrong_is_handed_out(std::string_view file, const PreparedExample& example) {
  auto decoded = structure_of(file);
  if (!decoded) return;
  EXPECT_EQ(decoded->metadata, example.metadata);
  const BrickFile opened = brick_file(bytes_of(file), *std::move(decoded));
  const SampleBricks samples(opened);
  const SpectrumBricks spectrum(opened);
  ASSERT_EQ(samples.size(), example.sample_bricks.size());
  ASSERT_EQ(spectrum.size(), example.spectrum_bricks.size());
  const auto look = [](const PreparedBricks& source, const std::vector<std::string>& expected) {
    for (std::size_t i = 0; i < source.size(); ++i) {
      try {
        EXPECT_EQ(text_of(source.brick(i)), expected[i]);
      } catch (const DatasetFileError&) {
      }
    }
  };
  look(samples, example.sample_bricks);
  look(spectrum, example.spectrum_bricks);
}

TEST(PreparedFormat, MatchesTheGoldenFile) {
  const std::string golden = bytes_of_file(MULTITETRA_TEST_DATA "/small.mtd");
  const PreparedExample example = small_prepared();
  EXPECT_TRUE(encoded(example) == golden)
      << "The format changed: raise its version, or keep it as it was.";
  EXPECT_EQ(error_in_bytes(golden), "whole");
  expect_nothing_wrong_is_handed_out(golden, example);
}

TEST(PreparedFormat, ReportsEveryChangedByte) {
  const PreparedExample example = small_prepared();
  const std::string whole = encoded(example);
  ASSERT_EQ(error_in_bytes(whole), "whole");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ change);
      EXPECT_NE(error_in_bytes(bytes), "whole") << "byte " << at;
      expect_nothing_wrong_is_handed_out(bytes, example);
    }
  }
}

TEST(PreparedFormat, ReportsWrongFileLengthsWhenOpened) {
  const std::string whole = encoded(small_prepared());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(error_in_structure(whole.substr(0, size)), "whole") << size;
  }
  EXPECT_NE(error_in_structure(whole + '\0'), "whole");
  EXPECT_NE(error_in_structure(whole + whole), "whole");
}

// ---- faulty files with matching checksums

struct Part {
  std::string name;
  std::string bytes;
  bool required = true;
};

// A file of these sections; whatever the arguments do not determine is valid.
std::string file_of(const std::vector<Part>& parts) {
  SectionTable table;
  std::uint64_t end = 0;
  for (const Part& part : parts) {
    table.push_back({.name = part.name,
                     .required = part.required,
                     .offset = section_begin(end),
                     .size = part.bytes.size(),
                     .checksum = checksum(bytes_of(part.bytes))});
    end = table.back().offset + table.back().size;
  }
  std::string file = encode_head(table);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    file.resize(table[i].offset, '\0');
    file += parts[i].bytes;
  }
  return file;
}

std::vector<Part> parts_of(std::string_view file) {
  std::vector<Part> parts;
  const auto table = decode_section_table(MemorySource(bytes_of(file)));
  for (const Section& section : *table) {
    parts.push_back({section.name, std::string(file.substr(section.offset, section.size))});
  }
  return parts;
}

std::vector<Part> small_parts() { return parts_of(encoded(small_prepared())); }

std::string& bytes_of_part(std::vector<Part>& parts, std::string_view name) {
  return std::find_if(parts.begin(), parts.end(), [&](const Part& p) { return p.name == name; })
      ->bytes;
}

template <typename Number>
void put(std::string& bytes, std::size_t at, Number number) {
  std::memcpy(bytes.data() + at, &number, sizeof(number));
}

// Recomputes the checksum after a change in the header or the table.
void mend_table_checksum(std::string& file) {
  std::uint32_t sections = 0;
  std::memcpy(&sections, file.data() + 12, sizeof(sections));
  const std::size_t covered = 24 + 40 * std::size_t{sections};
  put(file, covered, checksum(bytes_of(file).first(covered)));
}

TEST(PreparedFormat, IgnoresOptionalSectionsOfLaterVersions) {
  std::vector<Part> parts = small_parts();
  ASSERT_EQ(error_in_bytes(file_of(parts)), "whole");
  parts.insert(parts.begin() + 2, {"later", "whatever", false});
  const std::string whole = file_of(parts);
  EXPECT_EQ(error_in_bytes(whole), "whole");
  expect_nothing_wrong_is_handed_out(whole, small_prepared());

  std::string changed = whole;
  changed[changed.find("whatever")] = 'W';
  EXPECT_EQ(error_in_structure(changed), "whole");
  expect_contains(error_in_bytes(changed), "\"later\": its checksum");

  parts[2].required = true;
  expect_contains(error_in_structure(file_of(parts)), "\"later\": it is unknown to this program");
  EXPECT_EQ(structure_of(file_of(parts)).error().code, ErrorCode::kUnsupportedVersion);
}

TEST(PreparedFormat, NamesMissingAndDuplicateSections) {
  const std::vector<Part> parts = small_parts();
  ASSERT_EQ(parts.size(), 8U);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::vector<Part> fewer = parts;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    expect_contains(error_in_structure(file_of(fewer)), "\"" + parts[i].name + "\": it is missing");
    std::vector<Part> more = parts;
    more.push_back(parts[i]);
    expect_contains(error_in_structure(file_of(more)), "\"" + parts[i].name + "\" twice");
  }
}

TEST(PreparedFormat, HasTheSectionsOfErrorsUnlessTheMetadataSaysThatTheyAreMissing) {
  std::vector<Part> parts = small_parts();
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.info.missing = kMissingErrors;
  bytes_of_part(parts, "metadata") = metadata_text(metadata);
  expect_contains(error_in_structure(file_of(parts)), "\"specidx\": it is there");
  std::erase_if(parts, [](const Part& part) { return part.name == "specidx"; });
  expect_contains(error_in_structure(file_of(parts)), "\"spectrum\": it is there");
  std::erase_if(parts, [](const Part& part) { return part.name == "spectrum"; });
  EXPECT_EQ(error_in_bytes(file_of(parts)), "whole");
  metadata.info.missing = "samples";
  bytes_of_part(parts, "metadata") = metadata_text(metadata);
  expect_contains(error_in_structure(file_of(parts)), "missing \"samples\" is unknown");
}

TEST(PreparedFormat, ReportsSectionsWhoseSizeContradictsTheMetadata) {
  for (const char* name : {"specidx", "smplidx"}) {
    for (const bool longer : {false, true}) {
      std::vector<Part> parts = small_parts();
      std::string& bytes = bytes_of_part(parts, name);
      bytes.resize(longer ? bytes.size() + 1 : bytes.size() - 1);
      expect_contains(error_in_structure(file_of(parts)),
                      "\"" + std::string(name) + "\": it has " + std::to_string(bytes.size()));
    }
  }
}

TEST(PreparedFormat, RejectsOtherVersionsWithTheRemedy) {
  for (const std::uint32_t version : {0U, 2U, 0xFFFFFFFFU}) {
    std::string file = encoded(small_prepared());
    put(file, 8, version);
    mend_table_checksum(file);
    EXPECT_EQ(structure_of(file).error().code, ErrorCode::kUnsupportedVersion);
    expect_contains(error_in_structure(file), "version " + std::to_string(version));
    expect_contains(error_in_structure(file), "repare the dataset again");
  }
}

TEST(PreparedFormat, RejectsFilesOfRelease0WithTheRemedy) {
  std::string file = encoded(small_prepared());
  file.replace(0, 8, "\x89MTD\r\n\x1a\n");
  EXPECT_EQ(structure_of(file).error().code, ErrorCode::kUnsupportedVersion);
  expect_contains(error_in_structure(file), "written by release 0.x");
  expect_contains(error_in_structure(file), "prepare the dataset again");
}

TEST(PreparedFormat, ReportsOverflowingSizesAndOffsets) {
  const std::string whole = encoded(small_prepared());
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t entry = 0; entry < 8; ++entry) {
    for (const std::size_t at : {24 + 40 * entry + 16, 24 + 40 * entry + 24}) {
      for (const std::uint64_t value :
           {std::uint64_t{1}, std::uint64_t{1} << 62, most - 63, most - 300, most}) {
        std::string file = whole;
        put(file, at, value);
        mend_table_checksum(file);
        EXPECT_NE(error_in_structure(file), "whole") << "offset " << at << " value " << value;
      }
    }
  }
}

TEST(PreparedFormat, ReportsUnknownNamesAndFlags) {
  const std::string whole = encoded(small_prepared());
  for (const auto& [at, byte] : std::vector<std::pair<std::size_t, char>>{
           {24, '\0'}, {24, '\n'}, {24 + 1, '\0'}, {24 + 8, 3}, {24 + 11, 1}, {24 + 12, 1}}) {
    std::string file = whole;
    file[at] = byte;
    mend_table_checksum(file);
    expect_contains(error_in_structure(file), "\"table\"");
  }
}

TEST(PreparedFormat, ReportsAnIndexThatDoesNotFillItsSection) {
  const std::vector<Part> whole = small_parts();
  for (const auto& [index, bricks] :
       {std::pair("specidx", "spectrum"), std::pair("smplidx", "samples")}) {
    for (const std::uint32_t change : {1U << 2, 1U << 10, 1U << 27}) {
      std::vector<Part> parts = whole;
      std::string& bytes = bytes_of_part(parts, index);
      std::uint32_t size = 0;
      std::memcpy(&size, bytes.data(), sizeof(size));
      put(bytes, 0, size ^ change);
      expect_contains(error_in_bytes(file_of(parts)),
                      "do not fill section \"" + std::string(bricks));
      expect_nothing_wrong_is_handed_out(file_of(parts), small_prepared());
    }
    std::vector<Part> parts = whole;
    bytes_of_part(parts, bricks) += "xxxx";
    expect_contains(error_in_bytes(file_of(parts)), "do not fill section \"" + std::string(bricks));
  }
}

TEST(PreparedFormat, ReportsABrickChecksumMismatchInAValidSection) {
  std::vector<Part> parts = small_parts();
  bytes_of_part(parts, "samples").back() ^= 1;  // In brick 2, the last one.
  EXPECT_EQ(error_in_structure(file_of(parts)), "whole");
  expect_contains(error_in_bytes(file_of(parts)), "\"samples\": brick 2: its checksum");
  expect_nothing_wrong_is_handed_out(file_of(parts), small_prepared());
}

// Replaces the only brick of a file of floats and updates all checksums.
std::string with_only_brick(BrickCodec codec, const std::string& packed) {
  const PreparedExample example = prepared_example(
      {.dims = {3, 1, 1}, .index_to_world = {}, .samples = std::vector<float>{1, 2, 3}});
  std::vector<Part> parts = parts_of(encoded(example));
  bytes_of_part(parts, "samples") = packed;
  std::string& index = bytes_of_part(parts, "smplidx");
  put(index, 0, size_with_codec(packed.size(), codec));
  put(index, 4, brick_checksum(bytes_of(packed)));
  return file_of(parts);
}

void expect_only_brick_refused(const std::string& file, const std::string& reason) {
  expect_contains(error_in_bytes(file), "brick 0: " + reason);
  const BrickFile opened = brick_file(bytes_of(file), *structure_of(file));
  EXPECT_THROW((void)SampleBricks(opened).brick(0), DatasetFileError);
}

TEST(PreparedFormat, ReportsAnInfiniteSampleWhenItsBrickIsRead) {
  const std::array<float, 3> samples = {1, -std::numeric_limits<float>::infinity(), 3};
  const auto raw = std::as_bytes(std::span(samples));
  expect_only_brick_refused(with_only_brick(BrickCodec::kRaw, text_of(raw)),
                            "it has an infinite sample");
  expect_only_brick_refused(with_only_brick(BrickCodec::kConstant, text_of(raw.subspan(4, 4))),
                            "it has an infinite sample");
}

TEST(PreparedFormat, ReportsBricksThatUnpackToWrongData) {
  const std::vector<std::byte> longer(16, std::byte{7});
  const std::vector<std::byte> many(100'000, std::byte{7});
  for (const auto& [codec, packed] :
       std::vector<std::pair<int, std::string>>{{0, "short"},
                                                {0, text_of(std::span<const std::byte>(longer))},
                                                {1, "12345"},
                                                {2, "no frame"},
                                                {2, std::string(40, '\xff')},
                                                {3, "123456789012"},
                                                {15, "123456789012"}}) {
    expect_only_brick_refused(with_only_brick(static_cast<BrickCodec>(codec), packed),
                              "it cannot be decompressed");
  }
  // A frame that declares a size larger than any brick.
  std::vector<std::byte> ramp(many);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::byte>(i / 1000);
  const PackedBrick frame = pack_brick(ramp, 4);
  ASSERT_EQ(frame.codec, BrickCodec::kBlosc);
  expect_only_brick_refused(
      with_only_brick(frame.codec, text_of(std::span<const std::byte>(frame.bytes))),
      "it cannot be decompressed");
}

TEST(PreparedFormat, ReportsPackedSectionsThatUnpackToWrongData) {
  for (const char* const section : {"coarse", "ranges"}) {
    for (const std::string& bytes : {std::string(), std::string(3, 'x'), std::string(13, 'x'),
                                     std::string(1000, 'x'), std::string("\x03\0\0\x10xyz", 7)}) {
      std::vector<Part> parts = small_parts();
      bytes_of_part(parts, section) = bytes;
      expect_contains(error_in_bytes(file_of(parts)), "\"" + std::string(section) + "\": ");
    }
  }
}

TEST(PreparedFormat, ReportsMetadataThatContradictsTheSamplesWhenVerified) {
  const PreparedExample example = small_prepared();
  for (const int field : {0, 1, 2}) {
    PreparedExample other = example;
    if (field == 0) other.metadata.info.min -= 1;
    if (field == 1) other.metadata.info.max += 1;
    if (field == 2) {
      ++other.metadata.info.void_samples;
      --other.metadata.info.histogram.counts[0];
    }
    EXPECT_EQ(error_in_structure(encoded(other)), "whole");
    expect_contains(error_in_bytes(encoded(other)), "\"metadata\": the metadata declare");
  }
}

TEST(PreparedFormat, ReportsMetadataOfAHugeVolumeInASmallFile) {
  std::vector<Part> parts = small_parts();
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.info.dims = {4097, 4097, 4097};
  metadata.info.grid_exponent = 12;
  metadata.info.histogram.counts = {std::uint64_t{4097} * 4097 * 4097};
  bytes_of_part(parts, "metadata") = metadata_text(metadata);
  expect_contains(error_in_structure(file_of(parts)), "\"smplidx\": it has 24 bytes");
  bytes_of_part(parts, "metadata").resize((1 << 20) + 1, ' ');
  expect_contains(error_in_structure(file_of(parts)), "more than 1048576");
}

}  // namespace
}  // namespace multitetra
