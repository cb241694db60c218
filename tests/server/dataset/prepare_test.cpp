// Preparing a volume into a mapped file, and the guarantees that hold for every way of preparing.

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

using testing::prepared_settings;
using testing::PreparedSetting;
namespace fields = testing::fields;

std::filesystem::path prepare_file(const TemporaryFolder& folder, const PreparedSetting& setting) {
  std::filesystem::path file = folder.path() / (setting.name + ".mtd");
  prepare(*source_of(setting.volume),
          {.name = setting.name, .outside = setting.outside, .margin = setting.margin}, file,
          {.file = setting.name, .digest = {}});
  return file;
}

template <typename Bytes>
bool equal(Bytes a, Bytes b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

TEST(Prepare, WritesTheSameDatasetAsInMemory) {
  const TemporaryFolder folder;
  for (const PreparedSetting& setting : prepared_settings()) {
    SCOPED_TRACE(setting.name);
    const std::filesystem::path path = prepare_file(folder, setting);
    verify_dataset(path);
    const DatasetPtr file = open_dataset(path);
    const DatasetPtr memory = testing::prepared(setting);
    // Only files have a content id: datasets in memory have no checksums.
    EXPECT_NE(file->info.content_id, 0);
    DatasetInfo info = memory->info;
    info.content_id = file->info.content_id;
    EXPECT_EQ(file->info, info);
    EXPECT_TRUE(equal(file->coarse.bytes(), memory->coarse.bytes()));
    EXPECT_TRUE(equal(file->ranges.bytes(), memory->ranges.bytes()));
    EXPECT_EQ(file->spectrum.bins, memory->spectrum.bins);
    EXPECT_EQ(file->spectrum.voxel, memory->spectrum.voxel);
    for (std::size_t i = 0; i < file->spectrum.layout.size(); ++i) {
      EXPECT_TRUE(equal(file->spectrum.bricks->brick(i), memory->spectrum.bricks->brick(i)));
    }
    const Volume whole = whole_volume(*file);
    EXPECT_EQ(whole.dims, setting.volume.dims);
    std::visit(
        [&](const auto& samples) {
          using Samples = std::decay_t<decltype(samples)>;
          EXPECT_TRUE(equal(std::as_bytes(std::span(samples)),
                            std::as_bytes(std::span(std::get<Samples>(setting.volume.samples)))));
        },
        whole.samples);
  }
}

TEST(Complete, WritesTheBytesOfOnePreparation) {
  const TemporaryFolder folder;
  std::vector<PreparedSetting> settings = prepared_settings();
  settings.push_back({"tiny", fields::noise({3, 5, 4}, 5)});
  Volume ball = fields::ball({96, 90, 80}, 9);
  for (float& sample : std::get<std::vector<float>>(ball.samples)) sample = std::max(sample, 0.0F);
  settings.push_back({"ball_in_zeros", ball});
  settings.push_back({"ball_in_zeros_in_a_value", ball, 2.0, 3});
  for (const PreparedSetting& setting : settings) {
    SCOPED_TRACE(setting.name);
    const std::filesystem::path whole = prepare_file(folder, setting);
    const std::filesystem::path file = folder.path() / "samples.mtd";
    prepare(*source_of(setting.volume),
            {.name = setting.name,
             .outside = setting.outside,
             .margin = setting.margin,
             .samples_only = true},
            file, {.file = setting.name, .digest = {}});
    verify_dataset(file);
    const DatasetPtr before = open_dataset(file);
    EXPECT_EQ(before->info.missing, kMissingErrors);
    EXPECT_EQ(before->spectrum.bricks, nullptr);
    EXPECT_NE(before->info.content_id, open_dataset(whole)->info.content_id);
    Volume placed = setting.volume;  // The same samples elsewhere.
    placed.index_to_world.translation[0] += 1;
    const std::filesystem::path moved = folder.path() / "moved.mtd";
    prepare(*source_of(placed),
            {.name = setting.name, .outside = setting.outside, .margin = setting.margin}, moved,
            {.file = setting.name, .digest = {}});
    EXPECT_NE(open_dataset(moved)->info.content_id, open_dataset(whole)->info.content_id);
    EXPECT_EQ(complete(file, {.for_each = sequentially}, file).missing, "");
    EXPECT_TRUE(bytes_of_file(file) == bytes_of_file(whole));
    before->check();  // The open file is still the one without errors.
    EXPECT_THROW((void)complete(file, {}, file), DatasetFileError);
  }
}

TEST(PrepareInMemory, EqualsTheFileWithoutErrors) {
  const TemporaryFolder folder;
  std::vector<PreparedSetting> settings = prepared_settings();
  settings.push_back({"tiny", fields::noise({3, 5, 4}, 5)});
  settings.push_back({"point", fields::noise({1, 1, 1}, 5)});
  for (const PreparedSetting& setting : settings) {
    SCOPED_TRACE(setting.name);
    const PrepareOptions options = {.name = setting.name,
                                    .outside = setting.outside,
                                    .margin = setting.margin,
                                    .samples_only = true};
    const std::filesystem::path path = folder.path() / "samples.mtd";
    prepare(*source_of(setting.volume), options, path, {.file = setting.name, .digest = {}});
    const DatasetPtr file = open_dataset(path);
    const DatasetPtr memory = prepare_in_memory(*source_of(setting.volume), options);
    DatasetInfo info = file->info;
    info.content_id = 0;
    EXPECT_EQ(memory->info, info);
    const std::filesystem::path again = folder.path() / "again.mtd";
    write_samples(*memory, again, {.file = setting.name, .digest = {}});
    EXPECT_TRUE(bytes_of_file(again) == bytes_of_file(path));
    EXPECT_TRUE(equal(memory->coarse.bytes(), file->coarse.bytes()));
    EXPECT_TRUE(equal(memory->ranges.bytes(), file->ranges.bytes()));
    EXPECT_EQ(memory->spectrum.bins.edges(), file->spectrum.bins.edges());
    for (std::size_t i = 0; i < BrickLayout(info.dims).size(); ++i) {
      EXPECT_TRUE(equal(memory->samples->brick(i), file->samples->brick(i)));
    }
  }
}

TEST(Prepare, PacksConstantRegionsIntoAlmostNoBytes) {
  const TemporaryFolder folder;
  Volume volume = fields::ball({96, 96, 96}, 9);
  for (float& sample : std::get<std::vector<float>>(volume.samples))
    sample = sample > 0 ? sample : 0;
  const std::filesystem::path file = prepare_file(folder, {"ball", volume});
  EXPECT_LT(std::filesystem::file_size(file), volume.size() * sizeof(float) / 40);
  verify_dataset(file);
  EXPECT_EQ(whole_volume(*open_dataset(file)).samples, volume.samples);
  // All samples are zero.
  volume.samples = std::vector<float>(volume.size());
  const std::filesystem::path zeros = prepare_file(folder, {"zeros", volume});
  verify_dataset(zeros);
  EXPECT_EQ(whole_volume(*open_dataset(zeros)).samples, volume.samples);
}

TEST(Prepare, WritesTheSameBytesWithAnyThreadCount) {
  const TemporaryFolder folder;
  const PreparedSetting setting = {"noise", fields::noise({300, 40, 35}, 6)};
  std::optional<std::string> expected;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    const std::string bytes = bytes_of_file(prepare_file(folder, setting));
    if (!expected) expected = bytes;
    EXPECT_TRUE(bytes == *expected) << threads << " threads";
  }
}

TEST(Prepare, WritesTheSameBytesWithAnyMemory) {
  const TemporaryFolder folder;
  for (const PreparedSetting& setting :
       {PreparedSetting{"wide", fields::noise({150, 70, 20}, 6)},
        PreparedSetting{"long", fields::integer_noise({12, 37, 140}, 90, 2), 0.0, 3}}) {
    const std::string ample = bytes_of_file(prepare_file(folder, setting));
    for (const std::size_t bytes : {std::size_t{1}, std::size_t{70} << 20}) {
      const std::filesystem::path scarce = folder.path() / "scarce.mtd";
      prepare(*source_of(setting.volume),
              {.name = setting.name,
               .outside = setting.outside,
               .margin = setting.margin,
               .slab_bytes = bytes / 8,
               .column_bytes = bytes},
              scarce, {.file = setting.name, .digest = {}});
      EXPECT_TRUE(bytes_of_file(scarce) == ample) << setting.name << ", " << bytes << " bytes";
    }
  }
}

TEST(Prepare, ReportsProgress) {
  const TemporaryFolder folder;
  std::vector<std::string> passes;
  std::uint64_t last = 0;
  prepare(*source_of(fields::noise({20, 20, 50}, 1)),
          {.name = "noise",
           .progress =
               [&](const char* pass, std::uint64_t done, std::uint64_t all) {
                 if (passes.empty() || passes.back() != pass) {
                   passes.emplace_back(pass);
                   last = 0;
                 }
                 EXPECT_GT(done, last);
                 EXPECT_EQ(all, 20000U);
                 last = done;
               }},
          folder.path() / "noise.mtd", {});
  EXPECT_EQ(passes, (std::vector<std::string>{"range", "histogram", "errors"}));
  EXPECT_EQ(last, 20000U);
}

TEST(Prepare, RejectsOptionsOutsideTheirRangeAndLeavesNoFile) {
  const TemporaryFolder folder;
  const auto attempt = [&](PrepareOptions options) {
    prepare(*source_of(fields::noise({5, 5, 5}, 1)), options, folder.path() / "x.mtd", {});
  };
  EXPECT_THROW(attempt({.name = "x", .bins = 0}), std::invalid_argument);
  EXPECT_THROW(attempt({.name = "x", .bins = 257}), std::invalid_argument);
  EXPECT_THROW(attempt({.name = "x", .margin = -1}), std::invalid_argument);
  EXPECT_THROW(attempt({.name = ""}), std::invalid_argument);
  for (const double spacing : {0.0, 1e-31, 1e31}) {
    EXPECT_THROW(prepare(*source_of(fields::noise({5, 5, 5}, 1, {1, 1, spacing})), {.name = "x"},
                         folder.path() / "x.mtd", {}),
                 std::invalid_argument)
        << spacing;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Prepare, AcceptsExtremeSpacings) {
  for (const Vec3& spacing :
       {Vec3{1e-30, 1e-30, 1e-30}, Vec3{1e30, 1e30, 1e30}, Vec3{1e-30, 1, 1e30}}) {
    const DatasetPtr dataset =
        testing::prepared({"noise", fields::noise({20, 20, 20}, 1, spacing)});
    const SpectrumErrors spectrum(*dataset, 0.5, ErrorMeasure::kCertified, TopologyRule::kExact);
    EXPECT_GT(spectrum.bound(DividingPoint({8, 8, 8})).error, 0);
  }
}

TEST(OpenDataset, RejectsWrongBins) {
  const TemporaryFolder folder;
  const DatasetPtr good = testing::prepared({"noise", fields::noise({20, 20, 20}, 1)});
  const auto write = [&](std::span<const std::byte> coarse, std::span<const std::byte> ranges,
                         std::span<const float> edges) {
    const std::filesystem::path path = folder.path() / "bad.mtd";
    DatasetWriter writer(path, good->info);
    const BrickLayout layout(good->info.dims);
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const RetainedBytes brick = good->samples->brick(i);
      writer.add_samples({brick.data(), brick.size()});
    }
    writer.finish({.info = good->info, .source = {}, .program_version = "1"},
                  {.coarse = coarse, .ranges = ranges, .bins = std::as_bytes(edges)});
    return path;
  };
  const std::vector<float> edges = good->spectrum.bins.edges();
  const std::span<const std::byte> coarse = good->coarse.bytes();
  const std::span<const std::byte> ranges = good->ranges.bytes();
  EXPECT_NO_THROW((void)open_dataset(write(coarse, ranges, edges)));
  const auto complaint = [](const std::filesystem::path& path) -> std::string {
    try {
      (void)open_dataset(path);
    } catch (const DatasetFileError& error) {
      return error.what();
    }
    return "";
  };
  for (const std::vector<float>& bad :
       {std::vector<float>{1}, std::vector<float>{2, 1}, std::vector<float>{0, 0},
        std::vector<float>{0, std::numeric_limits<float>::quiet_NaN()},
        std::vector<float>(258, 0.0F)}) {
    EXPECT_NE(complaint(write(coarse, ranges, bad)).find("\"bins\""), std::string::npos);
  }
}

}  // namespace
}  // namespace multitetra
