#include "server/dataset/prepared_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/dataset/prepare.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "server/volume/generators/generators.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/memory_source.hpp"
#include "tests/support/prepared_example.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const DatasetFileError& error) {
    return error.what();
  }
  return "none";
}

std::string error_of_opening(const fs::path& file) {
  const std::string text = error_of([&] { PreparedFile{file}; });
  EXPECT_TRUE(text == "none" || text.find(file.filename().string()) != std::string::npos)
      << "The error does not name the file: " << text;
  return text;
}

std::string error_of_verifying(const fs::path& file) {
  return error_of([&] { verify_dataset(file); });
}

// Changes one byte of the file, `at` bytes into a section.
void damage_file(const fs::path& file, const char* section, std::size_t at) {
  std::string bytes = bytes_of_file(file);
  const auto table = decode_section_table(MemorySource(bytes_of(bytes)));
  char& byte = bytes[find_section(*table, section)->offset + at];
  byte = static_cast<char>(byte ^ 1);
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(PreparedFile, OpensWrittenFilesAndLeavesNoTemporaries) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "head.mtd";
  const PreparedExample example =
      prepared_example(generate(GeneratorKind::kHead, {.size = 40, .noise = 10}));
  ASSERT_EQ(example.sample_bricks.size(), 27U);
  write_prepared(path, example);
  expect_holds(PreparedFile(path), example);
  EXPECT_EQ(error_of_verifying(path), "none");
  EXPECT_EQ(entries_of(folder.path()), 1U);
}

TEST(PreparedFile, RoundTripsEveryTypeExactly) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Samples> all = {std::vector<std::uint8_t>{0, 1, 2, 3, 254, 255},
                                    std::vector<std::int8_t>{-128, -1, 0, 1, 2, 127},
                                    std::vector<std::uint16_t>{0, 1, 2, 3, 4, 65535},
                                    std::vector<std::int16_t>{-32768, 0, 1, 2, 3, 32767},
                                    std::vector<float>{nan, -0.0F, 1e-45F, 3e38F, 1.0F / 3.0F, nan},
                                    std::vector<float>(6, nan)};
  for (const Samples& samples : all) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "a.mtd";
    const PreparedExample example = prepared_example({.dims = {3, 2, 1},
                                                      .spacing = {0.1, 1.0 / 3.0, 1e-9},
                                                      .index_to_world = {},
                                                      .samples = samples});
    ASSERT_TRUE(example.spectrum_bricks.empty()) << "A grid of 4 steps has no spectrum.";
    write_prepared(path, example);
    expect_holds(PreparedFile(path), example);
    EXPECT_EQ(error_of_verifying(path), "none");
  }
}

TEST(PreparedFile, AcceptsSamplesAndSpectrumInAnyOrderAndPieces) {
  const TemporaryFolder folder;
  const PreparedExample example =
      prepared_example(generate(GeneratorKind::kHead, {.size = 40, .noise = 10}));
  write_prepared(folder.path() / "a.mtd", example);

  DatasetWriter spectrum_first(folder.path() / "b.mtd", example.metadata.info);
  add_spectrum(spectrum_first, example);
  std::string layer;
  for (std::size_t i = 0; i < example.sample_bricks.size(); ++i) {
    layer += example.sample_bricks[i];
    if (i % 9 != 8) continue;
    spectrum_first.add_samples(bytes_of(layer));
    layer.clear();
  }
  finish(spectrum_first, example);
  EXPECT_EQ(bytes_of_file(folder.path() / "b.mtd"), bytes_of_file(folder.path() / "a.mtd"));

  DatasetWriter in_turns(folder.path() / "c.mtd", example.metadata.info);
  for (std::size_t i = 0; i < example.sample_bricks.size(); ++i) {
    in_turns.add_samples(bytes_of(example.sample_bricks[i]));
    if (i < example.spectrum_bricks.size()) {
      in_turns.add_spectrum_brick(i, bytes_of(example.spectrum_bricks[i]));
    }
  }
  finish(in_turns, example);
  expect_holds(PreparedFile(folder.path() / "c.mtd"), example);
}

TEST(PreparedFile, RoundTripsLargeSpectrumBricks) {
  const TemporaryFolder folder;
  PreparedExample example = small_prepared();
  example.spectrum_bricks = {std::string(70'000, 'a'), std::string(400'000, 'b'), "",
                             std::string(300'000, 'd')};
  for (std::size_t i = 0; i < 400'000; ++i)
    example.spectrum_bricks[1][i] = static_cast<char>(i / 9);
  write_prepared(folder.path() / "a.mtd", example);
  expect_holds(PreparedFile(folder.path() / "a.mtd"), example);
  EXPECT_EQ(error_of_verifying(folder.path() / "a.mtd"), "none");
}

TEST(PreparedFile, ReadsNoBrickWhenOpened) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  write_prepared(path, small_prepared());
  const PreparedFile file(path);
  EXPECT_EQ(file.samples()->reads(), 0U);
  EXPECT_EQ(file.spectrum()->reads(), 0U);
  (void)file.samples()->brick(1);
  (void)file.samples()->brick(1);
  EXPECT_EQ(file.samples()->reads(), 2U);
  EXPECT_EQ(file.spectrum()->reads(), 0U);
}

TEST(PreparedFile, ReportsADamagedBrickOnEachReadButNoOthers) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  const PreparedExample example = small_prepared();
  write_prepared(path, example);
  // A byte of brick 1.
  const std::size_t in_brick_1 =
      brick_begin(pack_brick(bytes_of(example.sample_bricks[0]), 2).bytes.size()) + 5;
  damage_file(path, "samples", in_brick_1);
  const PreparedFile file(path);
  for (int times = 0; times < 2; ++times) {
    EXPECT_EQ(text_of(file.samples()->brick(0)), example.sample_bricks[0]);
    EXPECT_EQ(text_of(file.samples()->brick(2)), example.sample_bricks[2]);
    const std::string text = error_of([&] { (void)file.samples()->brick(1); });
    for (const char* part : {"a.mtd", "\"samples\"", "brick 1", "Prepare the dataset again"}) {
      expect_contains(text, part);
    }
  }
  EXPECT_EQ(all_bricks(*file.spectrum()), example.spectrum_bricks);
  expect_contains(error_of_verifying(path), "\"samples\": brick 1");
  damage_file(path, "samples", in_brick_1);
  EXPECT_EQ(error_of_verifying(path), "none");

  // The coarsest level comes first.
  std::size_t first = example.spectrum_bricks.size();
  in_file_order(SpectrumLayout(example.metadata.info), [&](std::size_t brick) {
    if (first == example.spectrum_bricks.size() && !example.spectrum_bricks[brick].empty()) {
      first = brick;
    }
  });
  damage_file(path, "spectrum", 0);
  const std::string brick = "\"spectrum\": brick " + std::to_string(first);
  expect_contains(error_of([&] { (void)PreparedFile(path).spectrum()->brick(first); }), brick);
  expect_contains(error_of_verifying(path), brick);
}

TEST(PreparedFile, ReportsDamageOutsideTheBricksWhenOpened) {
  for (const char* section :
       {"coarse", "ranges", "smplidx", "specidx", "metadata"}) {  // "bins" is empty here.
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "a.mtd";
    write_prepared(path, small_prepared());
    damage_file(path, section, 3);
    expect_contains(error_of_opening(path), "\"" + std::string(section) + "\"");
    expect_contains(error_of_verifying(path), "\"" + std::string(section) + "\"");
  }
}

// A remote file with a cache, in which all bytes behind the opening are damaged at first.
class DamagedInCache : public MemorySource {
 public:
  using MemorySource::MemorySource;
  [[nodiscard]] bool is_remote() const override { return true; }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    const RetainedBytes intact = MemorySource::bytes(offset, into.size());
    std::copy(intact.begin(), intact.end(), into.begin());
    if (is_damaged && !into.empty()) into[into.size() / 2] ^= std::byte{1};
  }
  [[nodiscard]] RetainedBytes bytes(std::uint64_t offset, std::size_t size) const override {
    return ByteSource::bytes(offset, size);
  }
  void invalidate(const FileRange&) const override { is_damaged = false; }

  mutable bool is_damaged = false;
};

TEST(PreparedFile, FetchesDamagedPartsOfARemoteFileOnceMore) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "dataset.mtd";
  prepare(*source_of(testing::fields::gyroid(20, 0.3, 8)), {.name = "remote"}, path, {});
  const std::string bytes = bytes_of_file(path);
  const PreparedFile local(path.string());
  const auto read_from_damaged = [&](const auto& read) {
    const auto source = std::make_shared<DamagedInCache>(std::as_bytes(std::span(bytes)));
    const PreparedFile remote("remote", source);
    source->is_damaged = true;
    const auto found = read(remote);
    const auto expected = read(local);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    EXPECT_FALSE(source->is_damaged);
  };
  read_from_damaged([](const PreparedFile& file) { return file.coarse(); });
  read_from_damaged([](const PreparedFile& file) { return file.ranges(); });
  read_from_damaged([](const PreparedFile& file) { return file.samples()->brick(0); });
  read_from_damaged([](const PreparedFile& file) { return file.spectrum()->brick(0); });
}

TEST(PreparedFile, RejectsOtherFiles) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "whole.mtd";
  write_prepared(path, small_prepared());
  const std::string whole = bytes_of_file(path);
  expect_contains(error_of_opening(folder.path() / "none.mtd"), "cannot be opened");
  expect_contains(error_of_opening(folder.path()), "not a regular file");
  expect_contains(error_of_opening(folder.file("empty.mtd", "")), "is not a prepared dataset");
  const fs::path volume = folder.file("head.nii.gz", std::string(10000, 'x'));
  EXPECT_EQ(error_of_opening(volume),
            volume.string() + " is not a prepared dataset. Prepare it first: multitetra-server " +
                "prepare " + volume.string() + " -o head.mtd");
  expect_contains(error_of_opening(folder.file("cut.mtd", whole.substr(0, whole.size() - 1))),
                  "declares a file of");
  ASSERT_EQ(::mkfifo((folder.path() / "pipe.mtd").c_str(), 0600), 0);
  expect_contains(error_of_opening(folder.path() / "pipe.mtd"), "not a regular file");
}

TEST(PreparedFile, RejectsFilesOfRelease0WithTheRemedy) {
  const std::string text = error_of_opening(MULTITETRA_TEST_DATA "/small_of_release_0.mtd");
  expect_contains(text, "written by release 0.x");
  expect_contains(text, "prepare the dataset again");
}

TEST(PreparedFile, KeepsItsContentWhenTheFileIsReplaced) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  const PreparedExample old = small_prepared();
  PreparedExample other = old;
  other.spectrum_bricks[0] = "another one";
  write_prepared(path, old);
  std::optional<PreparedFile> open(path);
  const auto samples = open->samples();
  const auto spectrum = open->spectrum();
  write_prepared(path, other);
  expect_holds(*open, old);
  open.reset();
  EXPECT_EQ(all_bricks(*samples), old.sample_bricks) << "A source keeps its file.";
  EXPECT_EQ(all_bricks(*spectrum), old.spectrum_bricks);
  expect_holds(PreparedFile(path), other);
}

TEST(PreparedFile, RemovesItsBricksFromTheCacheWhenDestroyed) {
  const TemporaryFolder folder;
  const PreparedExample example =
      prepared_example(generate(GeneratorKind::kHead, {.size = 40, .noise = 10}));
  write_prepared(folder.path() / "a.mtd", example);
  const auto files =
      std::make_shared<RemoteFiles>(RemoteFilesOptions{.memory_bytes = std::size_t{64} << 20});
  std::optional<PreparedFile> open(std::in_place, folder.path() / "a.mtd", files);
  EXPECT_EQ(all_bricks(*open->samples()), example.sample_bricks);
  EXPECT_GT(files->memory().counts().bytes, 0U);
  open.reset();
  EXPECT_EQ(files->memory().counts().bytes, 0U);
}

TEST(PreparedFile, AllowsConcurrentFirstReads) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  const PreparedExample example =
      prepared_example(generate(GeneratorKind::kHead, {.size = 40, .noise = 10}));
  write_prepared(path, example);
  damage_file(path, "spectrum", 0);
  const PreparedFile file(path);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      EXPECT_EQ(all_bricks(*file.samples()), example.sample_bricks);
      EXPECT_THROW((void)all_bricks(*file.spectrum()), DatasetFileError);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(file.samples()->reads(), 4 * example.sample_bricks.size());
}

TEST(VerifyDataset, ReportsProgress) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  write_prepared(path, prepared_example(generate(GeneratorKind::kHead, {.size = 40})));
  std::vector<double> fractions;
  verify_dataset(path, [&](double fraction) { fractions.push_back(fraction); });
  EXPECT_GT(fractions.size(), 10U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  struct Enough {};
  EXPECT_THROW(verify_dataset(path, [](double) { throw Enough(); }), Enough);
}

// ---- files that change while they are open

fs::path written_head(const TemporaryFolder& folder) {
  const fs::path path = folder.path() / "head.mtd";
  write_prepared(path, prepared_example(generate(GeneratorKind::kHead, {.size = 40, .noise = 10})));
  return path;
}

TEST(PreparedFile, ReportsTruncationWhileOpenAsDamage) {
  const TemporaryFolder folder;
  const fs::path path = written_head(folder);
  const PreparedFile file(path);
  const auto samples = file.samples();
  const std::byte first = samples->brick(0)[0];
  const RetainedBytes raw = file.spectrum()->brick(0);
  const std::string bytes = bytes_of_file(path);
  ASSERT_NE(bytes.find(text_of(raw)), std::string::npos) << "It is not read in place.";
  fs::resize_file(path, 4096);
  EXPECT_NE(error_of([&] { (void)samples->brick(0); }), "none") << static_cast<int>(first);
  EXPECT_NE(error_of([&] { file.check(); }), "none");
  // The truncated pages remain readable, as zeros, in a brick that is read in place.
  std::size_t sum = 0;
  for (const std::byte byte : raw) sum += static_cast<std::size_t>(byte);
  EXPECT_EQ(sum, 0U);
  expect_contains(error_of([&] { file.check(); }), "head.mtd': a part of it is missing");
  const TemporaryFolder another;
  EXPECT_EQ(error_of_opening(written_head(another)), "none") << "Others are as they were.";
}

TEST(PreparedFile, ReportsOverwritingWhileOpenAsDamage) {
  const TemporaryFolder folder;
  const fs::path path = written_head(folder);
  const PreparedFile file(path);
  (void)file.samples()->brick(0);
  damage_file(path, section_names::kSamples, 0);
  expect_contains(error_of([&] { (void)file.samples()->brick(0); }),
                  "it was overwritten while it was open");
  expect_contains(error_of([&] { (void)file.spectrum()->brick(0); }),
                  "it was overwritten while it was open");
}

}  // namespace
}  // namespace multitetra
