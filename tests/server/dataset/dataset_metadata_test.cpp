#include "server/dataset/dataset_metadata.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>

#include "tests/support/prepared_example.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using testing::expect_contains;

TEST(DatasetMetadata, RoundTripsExactly) {
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.info.spacing = {0.1, 1.0 / 3.0, 1e-9};
  metadata.info.index_to_world.translation = {1e300, -0.1, 7};
  for (const std::optional<double> outside : {std::optional<double>(), std::optional(-1.0 / 3.0)}) {
    metadata.info.outside = outside;
    const auto result = parse_metadata(metadata_text(metadata));
    ASSERT_TRUE(result) << result.error().text;
    EXPECT_EQ(*result, metadata);
  }
}

TEST(DatasetMetadata, RoundTripsOptionalSpaceAndUnits) {
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.info.meaning = {.space = WorldSpace::kRas,
                           .length_unit = "µm",
                           .value_unit = "kg/m³",
                           .geometry = GeometryBasis::kPartly,
                           .assumed = "spacing along z, origin",
                           .rounding = "up to 0.06"};
  std::string text = metadata_text(metadata);
  const auto result = parse_metadata(text);
  ASSERT_TRUE(result) << result.error().text;
  EXPECT_EQ(result->info.meaning, metadata.info.meaning);
  for (const char* key : {"\"space\":", "\"length_unit\":", "\"value_unit\":", "\"geometry\":",
                          "\"assumed\":", "\"rounding\":"}) {
    text.replace(text.find(key), std::string(key).size(), "\"x\":");
  }
  const auto older = parse_metadata(text);
  ASSERT_TRUE(older) << older.error().text;
  EXPECT_EQ(older->info.meaning, PhysicalMeaning{});

  metadata.info.meaning.length_unit = std::string(65, 'm');
  EXPECT_FALSE(parse_metadata(metadata_text(metadata)));
}

TEST(DatasetMetadata, RoundTripsTheDisplayWindowAndNamesDamagedOnes) {
  DatasetMetadata metadata = small_prepared().metadata;
  EXPECT_EQ(metadata_text(metadata).find("display_window"), std::string::npos);
  metadata.info.display_window = {-2.5, 1500};
  const auto result = parse_metadata(metadata_text(metadata));
  ASSERT_TRUE(result) << result.error().text;
  EXPECT_EQ(result->info.display_window, (DisplayWindow{-2.5, 1500}));
  for (const std::string high : {"-2.5", "-3", "\"9\"", "null"}) {
    std::string spoilt = metadata_text(metadata);
    const std::string whole = "\"high\":1500.0";
    spoilt.replace(spoilt.find(whole), whole.size(), "\"high\":" + high);
    const auto damaged = parse_metadata(spoilt);
    ASSERT_FALSE(damaged) << high;
    expect_contains(damaged.error().text,
                    high == "null" || high == "\"9\"" ? "high" : "display_window");
  }
}

TEST(DatasetMetadata, RoundTripsSeriesMembersAndNamesDamagedOnes) {
  DatasetMetadata metadata = small_prepared().metadata;
  for (const SeriesMember& member :
       {SeriesMember{.series = "heart"},
        SeriesMember{
            .series = "heart", .field = "p", .time = 0.1, .time_unit = "s", .color = 0x00ff7f},
        SeriesMember{.series = "heart",
        .label = Label{.value = 3, .name = "liver", .color = 0x00dd65}}}) {
    metadata.info.member = member;
    const auto result = parse_metadata(metadata_text(metadata));
    ASSERT_TRUE(result) << result.error().text;
    EXPECT_EQ(result->info.member, member);
  }
  const std::string whole = metadata_text(metadata);
  for (const auto& [from, to, message] :
       {std::array{"\"#00dd65\"", "\"red\"", "color"}, std::array{"\"heart\"", "7", "series"},
        std::array{"\"heart\"", "\"\"", "member.series"}, std::array{":3.0", ":3.5", "whole"}}) {
    std::string spoilt = whole;
    const std::size_t at = spoilt.find("\"member\":");
    ASSERT_NE(at, std::string::npos);
    const std::size_t value = spoilt.find(from, at);
    ASSERT_NE(value, std::string::npos) << from;
    spoilt.replace(value, std::string(from).size(), to);
    const auto result = parse_metadata(spoilt);
    ASSERT_FALSE(result) << to;
    expect_contains(result.error().text, message);
  }
}

TEST(DatasetMetadata, RejectsControlCharactersInNamesAndUnits) {
  for (const std::string steering : {"\u009b2J", "a\u202eb", "a\u2028b", "\u061c"}) {
    DatasetMetadata metadata = small_prepared().metadata;
    const auto is_refused = [&metadata] { return !parse_metadata(metadata_text(metadata)); };
    metadata.info.meaning.value_unit = steering;
    EXPECT_TRUE(is_refused()) << "unit " << steering;
    metadata.info.meaning.value_unit = "kg";
    for (const SeriesMember& member :
         {SeriesMember{.series = steering}, SeriesMember{.series = "a", .field = steering},
          SeriesMember{.series = "a", .label = Label{.value = 3, .name = steering}}}) {
      metadata.info.member = member;
      EXPECT_TRUE(is_refused()) << "member " << steering;
    }
    metadata.info.member = SeriesMember{.series = "größe"};
    EXPECT_FALSE(is_refused());
  }
}

TEST(DatasetMetadata, RoundTripsTheVolumeOfALabel) {
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.label_volume = {.samples = 39, .surface_samples = 38.61};
  metadata.info.label_extent = metadata.label_volume->extent();
  const std::string text = metadata_text(metadata);
  const auto result = parse_metadata(text);
  ASSERT_TRUE(result) << result.error().text;
  EXPECT_EQ(*result, metadata);
  std::string spoilt = text;
  spoilt.replace(spoilt.find("38.61"), 5, "\"all\"");
  const auto refused = parse_metadata(spoilt);
  ASSERT_FALSE(refused);
  expect_contains(refused.error().text, "surface_samples");
}

TEST(DatasetMetadata, RoundTripsTheExtentOfALabel) {
  DatasetMetadata metadata = small_prepared().metadata;
  metadata.label_volume = {.samples = 2,
                           .surface_samples = 1.5,
                           .place = LabelExtent::Place{
                               .least = {0, 1, 1}, .greatest = {1, 1, 1}, .centroid = {0.5, 1, 1}}};
  metadata.info.label_extent = metadata.label_volume->extent();
  const auto result = parse_metadata(metadata_text(metadata));
  ASSERT_TRUE(result) << result.error().text;
  EXPECT_EQ(*result, metadata);
  metadata.label_volume->place->greatest[0] = metadata.info.dims[0];
  const auto refused = parse_metadata(metadata_text(metadata));
  ASSERT_FALSE(refused);
  expect_contains(refused.error().text, "label_volume");
}

TEST(DatasetMetadata, NamesMissingOrWronglyTypedFields) {
  const std::string whole = metadata_text(small_prepared().metadata);
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
