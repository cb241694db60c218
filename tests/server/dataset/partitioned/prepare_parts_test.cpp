// Preparation on several machines gives the dataset of one process, bit for bit, despite failures.
#include "server/dataset/partitioned/prepare_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"
#ifdef MULTITETRA_SERVE_FOLDER
#include "tests/support/served_bucket.hpp"
#endif

namespace multitetra {
namespace {

namespace fs = std::filesystem;
namespace fields = testing::fields;
using testing::PreparedSetting;

// The contents of the files in a folder, by name.
std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      content[entry.path().lexically_relative(folder).string()] = bytes_of_file(entry.path());
    }
  }
  return content;
}

PrepareOptions options_for(const PreparedSetting& setting) {
  return {.name = setting.name, .outside = setting.outside, .margin = setting.margin};
}

// The files that preparation by one process writes.
std::map<std::string, std::string> by_one_process(const PreparedSetting& setting) {
  const TemporaryFolder folder;
  prepare(*source_of(setting.volume), options_for(setting), folder.path() / "all.mtd", {});
  return content_of(folder.path());
}

void plan(const PreparedSetting& setting, const fs::path& dataset, std::size_t parts) {
  const auto source = source_of(setting.volume);
  VolumeSurvey found = survey(*source, options_for(setting));
  write_plan(dataset,
             {.metadata = {.info = found.info, .source = {}, .program_version = MULTITETRA_VERSION},
              .bins = found.bins,
              .parts = parts});
}

void make_part(const PreparedSetting& setting, const fs::path& dataset, std::size_t part) {
  prepare_part(*source_of(setting.volume), dataset, part);
}

std::vector<PreparedSetting> settings() {
  return {{"long", fields::integer_noise({20, 30, 300}, 90, 2), 3.0, 5},
          {"wide", fields::noise({270, 140, 20}, 6)},
          {"masked", fields::masked_gyroid(135, 10), std::nullopt, 3},
          {"skewed", testing::skewed_noise({22, 131, 18}, 12), std::nullopt, 7},
          {"small", fields::ball({9, 9, 9}, 3), 0.0, 1}};
}

// A ball in a volume that is 0 elsewhere.
Volume ball_at(const std::array<std::int32_t, 3>& dims, const std::array<double, 3>& center) {
  return fields::sampled<float>(dims, [&](int x, int y, int z) {
    const double distance = std::hypot(x - center[0], y - center[1], z - center[2]);
    return static_cast<float>(std::clamp(0.5 + (5 - distance) / 4, 0.0, 1.0));
  });
}

// One process computes no errors far from where samples vary; parts do.
TEST(PrepareParts, WriteTheErrorsOfConstantSurroundings) {
  for (const std::array<double, 3>& center :
       {std::array{16.2, 30.7, 24.1}, std::array{2.5, 3.0, 66.0}, std::array{50.0, 48.3, 8.9}}) {
    const PreparedSetting inside = {"ball", ball_at({60, 52, 70}, center)};
    for (const PreparedSetting& setting :
         {inside, PreparedSetting{"closed", inside.volume, 0.0, 1},
          PreparedSetting{"other outside", inside.volume, 2.0, 3}}) {
      SCOPED_TRACE(setting.name + " at " + std::to_string(center[0]));
      const TemporaryFolder folder;
      plan(setting, folder.path() / "all.mtd", 1);
      make_part(setting, folder.path() / "all.mtd", 0);
      merge_parts(folder.path() / "all.mtd");
      EXPECT_EQ(content_of(folder.path()), by_one_process(setting));
    }
  }
}

TEST(PrepareParts, WriteTheSameDatasetForAnyNumberOfParts) {
  std::mt19937 random(7);
  for (const PreparedSetting& setting : settings()) {
    const auto expected = by_one_process(setting);
    for (const std::size_t parts : {std::size_t{1}, std::size_t{2}, 2 + random() % 9}) {
      SCOPED_TRACE(setting.name + ", parts: " + std::to_string(parts));
      const TemporaryFolder folder;
      plan(setting, folder.path() / "all.mtd", parts);
      std::vector<std::size_t> order(parts);
      std::iota(order.begin(), order.end(), 0);
      std::shuffle(order.begin(), order.end(), random);
      for (const std::size_t part : order) make_part(setting, folder.path() / "all.mtd", part);
      merge_parts(folder.path() / "all.mtd");
      EXPECT_EQ(content_of(folder.path()), expected);
    }
  }
}

void expect_missing(const fs::path& dataset, const std::string& text) {
  try {
    merge_parts(dataset);
    FAIL();
  } catch (const DatasetFileError& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(PrepareParts, AcceptRepeatedParts) {
  const PreparedSetting setting = settings().front();
  const auto expected = by_one_process(setting);
  const TemporaryFolder folder;
  plan(setting, folder.path() / "all.mtd", 3);
  make_part(setting, folder.path() / "all.mtd", 2);
  make_part(setting, folder.path() / "all.mtd", 0);
  make_part(setting, folder.path() / "all.mtd", 2);
  expect_missing(folder.path() / "all.mtd", "missing parts: 2 (of ");
  make_part(setting, folder.path() / "all.mtd", 1);
  // A part whose process was killed after writing its files and before its record.
  fs::remove(folder.path() / "all.mtd.parts" / "1.json");
  expect_missing(folder.path() / "all.mtd", "missing parts: 1 (of ");
  make_part(setting, folder.path() / "all.mtd", 0);
  merge_parts(folder.path() / "all.mtd");
  EXPECT_EQ(content_of(folder.path()), expected);
}

TEST(PrepareParts, AcceptPartsCopiedIntoOneFolder) {
  const PreparedSetting setting = settings().front();
  const auto expected = by_one_process(setting);
  const TemporaryFolder machines;
  const TemporaryFolder folder;
  for (const std::size_t part : {0U, 1U, 2U}) {
    const fs::path here = machines.path() / std::to_string(part) / "all.mtd";
    fs::create_directory(here.parent_path());
    plan(setting, here, 3);
    make_part(setting, here, part);
    fs::copy(parts_folder(here), parts_folder(folder.path() / "all.mtd"),
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
  merge_parts(folder.path() / "all.mtd");
  EXPECT_EQ(content_of(folder.path()), expected);
}

#ifdef MULTITETRA_SERVE_FOLDER

TEST(PrepareParts, WriteTheSameDatasetThroughABucket) {
  const ServedBucket bucket;
  const fs::path dataset = "s3://volumes/of/all.mtd";
  const PreparedSetting setting = settings().front();
  expect_missing(dataset, "'s3://volumes/of/all.mtd.parts/plan.json': the plan does not exist");
  plan(setting, dataset, 7);  // Some of them are empty.
  for (const std::size_t part : {6U, 0U, 3U, 4U, 5U, 2U}) make_part(setting, dataset, part);
  bucket.folder().file("of/all.mtd.parts/notes.txt", "mine");
  expect_missing(dataset, "'s3://volumes/of/all.mtd.parts': missing parts: 2 (of 7)");
  make_part(setting, dataset, 1);
  const auto expected = by_one_process(setting);
  EXPECT_EQ(merge_parts(dataset).file_bytes, expected.at("all.mtd").size());
  const auto found = content_of(bucket.folder().path());
  EXPECT_EQ(found.size(), 2U);
  EXPECT_EQ(found.at("of/all.mtd"), expected.at("all.mtd"));
  EXPECT_EQ(found.at("of/all.mtd.parts/notes.txt"), "mine");
}

#endif

TEST(PrepareParts, LeaveOtherFilesInTheirFolder) {
  const PreparedSetting setting = settings().front();
  const TemporaryFolder folder;
  const fs::path dataset = folder.path() / "all.mtd";
  plan(setting, dataset, 1);
  make_part(setting, dataset, 0);
  folder.file("all.mtd.parts/notes.txt", "mine");
  folder.file("all.mtd.parts/measured/1.json", "mine");
  merge_parts(dataset);
  EXPECT_EQ(entries_of(parts_folder(dataset)), 2U);
  EXPECT_EQ(bytes_of_file(parts_folder(dataset) / "notes.txt"), "mine");
  EXPECT_EQ(bytes_of_file(parts_folder(dataset) / "measured" / "1.json"), "mine");
}

TEST(PrepareParts, RejectDamagedParts) {
  const PreparedSetting setting = settings().front();
  const TemporaryFolder folder;
  plan(setting, folder.path() / "all.mtd", 2);
  make_part(setting, folder.path() / "all.mtd", 0);
  make_part(setting, folder.path() / "all.mtd", 1);
  for (const auto& [name, whole] : content_of(folder.path())) {
    const fs::path file = folder.path() / name;
    for (std::size_t i = 0; i < whole.size(); i += 1 + whole.size() / 12) {
      std::string changed = whole;
      changed[i] = static_cast<char>(changed[i] ^ 4);
      if (whole[i] == ' ' || whole[i] == '\n') continue;  // White space is insignificant in JSON.
      std::ofstream(file, std::ios::binary | std::ios::trunc) << changed;
      EXPECT_ANY_THROW(merge_parts(folder.path() / "all.mtd")) << name << " " << i;
      ASSERT_FALSE(fs::exists(folder.path() / "all.mtd"));
    }
    std::ofstream(file, std::ios::binary | std::ios::trunc) << whole;
  }
  merge_parts(folder.path() / "all.mtd");
}

TEST(PrepareParts, RejectPartsOfAnotherVolumeOrPlan) {
  const PreparedSetting setting = settings().front();
  const TemporaryFolder folder;
  plan(setting, folder.path() / "all.mtd", 2);
  make_part(setting, folder.path() / "all.mtd", 0);
  EXPECT_THROW(make_part(settings()[1], folder.path() / "all.mtd", 1), VolumeFileError);
  EXPECT_THROW(make_part(setting, folder.path() / "all.mtd", 2), std::invalid_argument);
  make_part(setting, folder.path() / "all.mtd", 1);
  plan(setting, folder.path() / "all.mtd", 3);  // A new plan invalidates the existing parts.
  EXPECT_THROW(merge_parts(folder.path() / "all.mtd"), DatasetFileError);
}

TEST(PartBoxes, CoverTheVolumeInWholeCubes) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const GridCounts dims = {static_cast<std::int32_t>(1 + random() % 700),
                             static_cast<std::int32_t>(1 + random() % 700),
                             static_cast<std::int32_t>(1 + random() % 700)};
    const std::size_t parts = 1 + random() % 70;
    const std::vector<PartBox> boxes = part_boxes(dims, parts);
    ASSERT_EQ(boxes.size(), parts);
    std::uint64_t samples = 0;
    for (const PartBox& box : boxes) {
      samples += box.samples();
      for (int axis = 0; axis < 3; ++axis) {
        const std::int32_t side = dims[static_cast<std::size_t>(axis)];
        if (box.is_empty()) continue;
        EXPECT_EQ(box.begin[axis] % 128, 0);
        EXPECT_TRUE(box.end[axis] % 128 == 0 || box.end[axis] == side);
      }
    }
    EXPECT_EQ(samples, static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]) *
                           static_cast<std::uint64_t>(dims[2]));
  }
}

}  // namespace
}  // namespace multitetra
