#include "server/dataset/dataset_format.hpp"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/statistics.hpp"
#include "tests/dataset/small_dataset.hpp"
#include "tests/dataset/temporary_folder.hpp"

namespace multitetra {
namespace {

// Bytes in memory that count what is read of them.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::string_view bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    ASSERT_LE(offset, bytes_.size());
    ASSERT_LE(into.size(), bytes_.size() - offset);
    if (!into.empty()) std::memcpy(into.data(), bytes_.data() + offset, into.size());
  }

 private:
  std::string_view bytes_;
};

std::string encoded(const Dataset& dataset) {
  const auto samples = sample_bytes(dataset.volume.samples);
  std::string bytes = encode_head({.info = dataset.info,
                                   .source = {.file = "small.nrrd", .digest = "0123"},
                                   .program_version = "0.1.0"},
                                  samples);
  bytes.append(reinterpret_cast<const char*>(samples.data()), samples.size());
  return bytes;
}

// Bit for bit, so that NaN equals NaN.
bool same_bits(const Samples& a, const Samples& b) {
  const auto x = sample_bytes(a);
  const auto y = sample_bytes(b);
  return a.index() == b.index() && std::equal(x.begin(), x.end(), y.begin(), y.end());
}

Result<DecodedDataset> decoded(std::string_view bytes) {
  return decode_dataset(MemorySource(bytes));
}

std::string error_of(std::string_view bytes) {
  const auto result = decoded(bytes);
  return result ? "whole" : result.error().text;
}

TEST(DatasetFormat, EveryTypeComesBackBitForBit) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Samples> all = {
      std::vector<std::uint8_t>{0, 1, 2, 3, 254, 255},
      std::vector<std::int8_t>{-128, -1, 0, 1, 2, 127},
      std::vector<std::uint16_t>{0, 1, 2, 3, 4, 65535},
      std::vector<std::int16_t>{-32768, 0, 1, 2, 3, 32767},
      std::vector<float>{nan, -0.0F, 1e-45F, 3e38F, 1.0F / 3.0F, nan}};
  for (const Samples& samples : all) {
    Volume volume = {.dims = {3, 2, 1},
                     .spacing = {0.1, 1.0 / 3.0, 1e-9},
                     .index_to_world = {},
                     .samples = samples};
    volume.index_to_world.translation = {1e300, -0.1, 7};
    const DatasetPtr dataset = make_dataset(volume, "name", -1.0 / 3.0, 2);
    const auto result = decoded(encoded(*dataset));
    ASSERT_TRUE(result) << result.error().text;
    EXPECT_EQ(result->dataset.info, dataset->info);
    EXPECT_EQ(result->metadata.source, (SourceNote{"small.nrrd", "0123"}));
    EXPECT_EQ(result->metadata.program_version, "0.1.0");
    EXPECT_EQ(result->dataset.volume.dims, volume.dims);
    EXPECT_EQ(result->dataset.volume.spacing, volume.spacing);
    EXPECT_EQ(result->dataset.volume.index_to_world, volume.index_to_world);
    EXPECT_TRUE(same_bits(result->dataset.volume.samples, samples));
  }
}

TEST(DatasetFormat, AnInfiniteSampleIsReported) {
  const DatasetPtr finite = make_dataset(
      {.dims = {3, 1, 1}, .index_to_world = {}, .samples = std::vector<float>{1, 2, 3}}, "name");
  Dataset infinite = *finite;
  std::get<std::vector<float>>(infinite.volume.samples)[1] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(error_of(encoded(*finite)), "whole");
  EXPECT_NE(error_of(encoded(infinite)).find("infinite"), std::string::npos);
}

TEST(DatasetFormat, TheGoldenFileIsWhatThisVersionWritesAndReads) {
  const std::string golden = bytes_of_file(MULTITETRA_TEST_DATA "/small.mtd");
  ASSERT_FALSE(golden.empty());
  const DatasetPtr dataset = small_dataset();
  EXPECT_EQ(encoded(*dataset), golden)
      << "The format changed: raise its version, or keep it as it was.";
  const auto result = decoded(golden);
  ASSERT_TRUE(result) << result.error().text;
  EXPECT_EQ(result->dataset.info, dataset->info);
  EXPECT_EQ(result->dataset.volume.samples, dataset->volume.samples);
}

TEST(DatasetFormat, EveryChangedByteIsReported) {
  const std::string whole = encoded(*small_dataset());
  ASSERT_EQ(error_of(whole), "whole");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ change);
      EXPECT_NE(error_of(bytes), "whole") << "byte " << at;
      if (at < whole.size() - small_dataset()->volume.size() * 2) {
        EXPECT_FALSE(decode_metadata(MemorySource(bytes))) << "byte " << at;
      }
    }
  }
}

TEST(DatasetFormat, EveryOtherLengthIsReported) {
  const std::string whole = encoded(*small_dataset());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(error_of(whole.substr(0, size)), "whole") << size;
  }
  EXPECT_NE(error_of(whole + '\0'), "whole");
  EXPECT_NE(error_of(whole + whole), "whole");
}

// ---- files that somebody made with checksums that match

std::string number(std::uint64_t value, std::size_t bytes) {
  return {reinterpret_cast<const char*>(&value), bytes};
}

struct Part {
  std::string name;
  std::string bytes;
  std::uint32_t flags = 1;
};

// A file of these sections, with everything right that is not one of the arguments.
std::string file_of(const std::vector<Part>& parts, std::uint64_t version = 1) {
  const auto aligned = [](std::size_t offset) { return (offset + 63) / 64 * 64; };
  std::string table;
  std::size_t offset = 24 + 40 * parts.size() + 8;
  for (const Part& part : parts) {
    offset = aligned(offset);
    std::string name = part.name;
    name.resize(8);
    table += name + number(part.flags, 4) + number(0, 4) + number(offset, 8) +
             number(part.bytes.size(), 8) +
             number(XXH3_64bits(part.bytes.data(), part.bytes.size()), 8);
    offset += part.bytes.size();
  }
  std::string bytes = "\x89MTD\r\n\x1a\n" + number(version, 4) + number(parts.size(), 4) +
                      number(offset, 8) + table;
  bytes += number(XXH3_64bits(bytes.data(), bytes.size()), 8);
  for (const Part& part : parts) {
    bytes.resize(aligned(bytes.size()));
    bytes += part.bytes;
  }
  return bytes;
}

std::string small_metadata() {
  return metadata_text({.info = small_dataset()->info, .source = {}, .program_version = "0.1.0"});
}

std::string small_samples() {
  const DatasetPtr dataset = small_dataset();
  const auto samples = sample_bytes(dataset->volume.samples);
  return {reinterpret_cast<const char*>(samples.data()), samples.size()};
}

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

TEST(DatasetFormat, SectionsOfLaterVersionsArePassedOverUnlessRequired) {
  const Part metadata{"metadata", small_metadata()};
  const Part samples{"samples", small_samples()};
  EXPECT_EQ(error_of(file_of({metadata, samples})), "whole");
  EXPECT_EQ(error_of(file_of({metadata, {"spectrum", "whatever", 0}, samples})), "whole");
  EXPECT_EQ(error_of(file_of({metadata, samples, {"later", "", 0}})), "whole");
  expect_contains(error_of(file_of({metadata, samples, {"later", "x", 1}})), "\"later\"");

  std::string bytes = file_of({metadata, {"spectrum", "whatever", 0}, samples});
  bytes[bytes.find("whatever")] = 'W';
  expect_contains(error_of(bytes), "\"spectrum\": its checksum");
}

TEST(DatasetFormat, MissingDoubledAndContradictorySectionsAreReportedByName) {
  const Part metadata{"metadata", small_metadata()};
  const Part samples{"samples", small_samples()};
  expect_contains(error_of(file_of({samples})), "\"metadata\": it is missing");
  expect_contains(error_of(file_of({metadata})), "\"samples\": it is missing");
  expect_contains(error_of(file_of({metadata, metadata, samples})), "twice");
  expect_contains(error_of(file_of({metadata, {"samples", small_samples() + "xx"}})),
                  "dims and type need");
  expect_contains(error_of(file_of({metadata, samples}, 2)), "version is 2");
  EXPECT_EQ(decoded(file_of({metadata, samples}, 2)).error().code, ErrorCode::kUnsupportedVersion);
}

TEST(DatasetFormat, SizesAndOffsetsThatOverflowAreReported) {
  const std::string whole = file_of({{"metadata", small_metadata()}, {"samples", small_samples()}});
  for (const std::size_t at : {12u, 24u + 16u, 24u + 24u, 64u + 16u, 64u + 24u}) {
    for (const std::uint64_t value :
         {std::uint64_t{0}, std::uint64_t{1} << 62, std::numeric_limits<std::uint64_t>::max(),
          std::numeric_limits<std::uint64_t>::max() - 300}) {
      std::string bytes = whole;
      bytes.replace(at, at == 12 ? 4 : 8, number(value, at == 12 ? 4 : 8));
      const std::size_t covered = 24 + 2 * 40;
      bytes.replace(covered, 8, number(XXH3_64bits(bytes.data(), covered), 8));
      EXPECT_NE(error_of(bytes), "whole") << "offset " << at << " value " << value;
    }
  }
}

TEST(DatasetMetadata, EveryFieldThatIsMissingOrOfAnotherTypeIsNamed) {
  const std::string whole = small_metadata();
  ASSERT_TRUE(parse_metadata(whole));
  for (const char* field : {"name",
                            "dims",
                            "type",
                            "spacing",
                            "index_to_world",
                            "min",
                            "max",
                            "void_samples",
                            "outside",
                            "margin",
                            "grid_exponent",
                            "histogram",
                            "low",
                            "high",
                            "counts",
                            "suggested_isovalues",
                            "source",
                            "file",
                            "digest",
                            "program_version"}) {
    const std::string key = "\"" + std::string(field) + "\":";
    const std::size_t at = whole.find(key);
    ASSERT_NE(at, std::string::npos) << field;
    std::string missing = whole;
    missing.replace(at, key.size(), "\"x\":");
    const auto result = parse_metadata(missing);
    ASSERT_FALSE(result) << field;
    expect_contains(result.error().text, "\"" + std::string(field) + "\" is missing");
    for (const char* other : {"true", "-1", "\"x\"", "[[]]", "1e400", "99999999999"}) {
      std::string changed = whole;
      const std::size_t value = at + key.size();
      std::size_t end = whole.find_first_of(",}", value);
      if (whole[value] == '[' || whole[value] == '{') continue;
      changed.replace(value, end - value, other);
      const bool text = std::string(other) == "\"x\"";
      const bool number_in_place =
          std::string(other) == "-1" || std::string(other) == "99999999999";
      const bool may_be_text = text && whole[value] == '"' && std::string(field) != "type";
      const std::string name = field;
      const bool may_be_number =
          number_in_place &&
          (name == "outside" || name == "min" || name == "max" || name == "low" || name == "high");
      if (may_be_text || may_be_number) continue;
      EXPECT_FALSE(parse_metadata(changed)) << field << " = " << other;
    }
  }
  EXPECT_FALSE(parse_metadata(""));
  EXPECT_FALSE(parse_metadata("[]"));
  EXPECT_FALSE(parse_metadata(std::string(100000, '[')));
}

}  // namespace
}  // namespace multitetra
