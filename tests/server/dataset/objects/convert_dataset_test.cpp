// Files and folders of objects: the same dataset, and every damage is found.
#include "server/dataset/objects/convert_dataset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "server/dataset/objects/manifest.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/dataset/prepared_file.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
namespace fields = testing::fields;
using testing::prepared_settings;
using testing::PreparedSetting;

fs::path prepared_file(const TemporaryFolder& folder, const PreparedSetting& setting,
                       const std::string& name) {
  fs::path file = folder.path() / (name + ".mtd");
  prepare(*source_of(setting.volume),
          {.name = name, .outside = setting.outside, .margin = setting.margin}, file, {});
  return file;
}

std::shared_ptr<ObjectCache> small_cache() {
  return std::make_shared<ObjectCache>(ObjectCacheOptions{.memory_bytes = 1 << 20});
}

bool same(const KeptBytes& a, const KeptBytes& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool same(std::span<const std::byte> a, std::span<const std::byte> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

void expect_same(const DatasetPtr& a, const DatasetPtr& b) {
  EXPECT_EQ(a->info, b->info);  // With the content's id.
  EXPECT_EQ(a->spectrum.bins, b->spectrum.bins);
  EXPECT_TRUE(same(a->coarse.bytes(), b->coarse.bytes()));
  EXPECT_TRUE(same(a->ranges.bytes(), b->ranges.bytes()));
  for (std::size_t i = 0; i < BrickLayout(a->info.dims).size(); ++i) {
    EXPECT_TRUE(same(a->samples->brick(i), b->samples->brick(i))) << i;
  }
  for (std::size_t i = 0; i < a->spectrum.layout.size(); ++i) {
    EXPECT_TRUE(same(a->spectrum.bricks->brick(i), b->spectrum.bricks->brick(i))) << i;
  }
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(ConvertDataset, FileAndObjectsAreOneDatasetAndComeBackBitForBit) {
  std::vector<PreparedSetting> settings = prepared_settings();
  settings.push_back({"many_objects", fields::integer_noise({150, 20, 270}, 90, 2), 3.0, 5});
  const TemporaryFolder folder;
  for (const PreparedSetting& setting : settings) {
    SCOPED_TRACE(setting.name);
    const fs::path file = prepared_file(folder, setting, setting.name);
    const fs::path objects = folder.path() / setting.name;
    const ConvertedObjects converted = file_to_objects(file, objects, false);
    EXPECT_EQ(converted.objects + 1, files_below(objects).size());
    EXPECT_EQ(verify_objects(objects.string(), small_cache()).objects, converted.objects);
    expect_same(open_any_dataset(file.string()), open_any_dataset(objects.string(), small_cache()));
    const fs::path back = folder.path() / "back.mtd";
    objects_to_file(objects.string(), small_cache(), back);
    EXPECT_EQ(bytes_of_file(back), bytes_of_file(file));
  }
}

TEST(ConvertDataset, VersionsShareWhatIsEqualAndOthersGoWhenAsked) {
  const TemporaryFolder folder;
  Volume volume = fields::integer_noise({300, 130, 30}, 90, 2);
  const fs::path objects = folder.path() / "head";
  file_to_objects(prepared_file(folder, {"one", volume}, "head"), objects, false);
  const std::vector<fs::path> before = files_below(objects / "objects");
  std::visit([](auto& samples) { std::swap(samples[5], samples[6]); }, volume.samples);
  const fs::path file = prepared_file(folder, {"two", volume}, "head");
  const ConvertedObjects next = file_to_objects(file, objects, false);
  const std::vector<fs::path> both = files_below(objects / "objects");
  // Of six boxes of samples one is new; and the spectrum, both runs.
  EXPECT_LE(both.size(), before.size() + 4);
  EXPECT_TRUE(std::includes(both.begin(), both.end(), before.begin(), before.end()));
  const ConvertedObjects alone = file_to_objects(file, objects, true);
  EXPECT_GT(alone.removed_bytes, 0U);
  EXPECT_EQ(files_below(objects / "objects").size(), next.objects);
  verify_objects(objects.string(), small_cache());
}

TEST(ConvertDataset, DatasetsOfAStoreShareWhatIsEqual) {
  const TemporaryFolder folder;
  const fs::path store = folder.path() / "store";
  // Two times, which differ in one of six boxes of samples.
  Volume volume = fields::integer_noise({300, 130, 30}, 90, 2);
  const fs::path first = prepared_file(folder, {"one", volume}, "t0");
  std::visit([](auto& samples) { std::swap(samples[5], samples[6]); }, volume.samples);
  const fs::path second = prepared_file(folder, {"two", volume}, "t1");
  const ConvertedObjects one = file_to_shared_objects(first, store / "t0");
  const ConvertedObjects two = file_to_shared_objects(second, store / "t1");
  EXPECT_EQ(one.new_bytes, one.bytes);
  EXPECT_LT(two.new_bytes, two.bytes / 2);
  // Each object is there once: the first's, one box, the spectrum, both runs; and two manifests.
  const std::size_t objects = files_below(store / "objects").size();
  EXPECT_GT(objects, one.objects);
  EXPECT_LE(objects, one.objects + 4);
  EXPECT_EQ(files_below(store).size(), objects + 2);
  std::uint64_t bytes = 0;
  for (const fs::path& file : files_below(store / "objects")) bytes += fs::file_size(file);
  EXPECT_EQ(bytes, one.new_bytes + two.new_bytes);

  EXPECT_EQ(file_to_shared_objects(second, store / "t1").new_bytes, 0U);
  for (const auto& [file, name] : {std::pair{first, "t0"}, {second, "t1"}}) {
    const std::string place = (store / name).string();
    verify_objects(place, small_cache());
    expect_same(open_any_dataset(file.string()), open_any_dataset(place, small_cache()));
    const fs::path back = folder.path() / "back.mtd";
    objects_to_file(place, small_cache(), back);
    EXPECT_EQ(bytes_of_file(back), bytes_of_file(file));
  }

  EXPECT_EQ(remove_unused_objects(store), 0U);
  fs::remove_all(store / "t1");
  EXPECT_EQ(remove_unused_objects(store), two.new_bytes);
  EXPECT_EQ(files_below(store / "objects").size(), one.objects);
  verify_objects((store / "t0").string(), small_cache());
}

TEST(ConvertDataset, FindsEveryDamagedByteInObjects) {
  const TemporaryFolder folder;
  const fs::path objects = folder.path() / "noise";
  file_to_objects(prepared_file(folder, {"noise", fields::noise({20, 20, 20}, 1)}, "noise"),
                  objects, false);
  const auto damage_is_found = [&] {
    try {
      verify_objects(objects.string(), small_cache());
    } catch (const DatasetFileError&) {
      return true;
    } catch (const StoreError&) {
      return true;
    }
    return false;
  };
  for (const fs::path& file : files_below(objects)) {
    const std::string whole = bytes_of_file(file);
    const auto write = [&](const std::string& bytes) {
      std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
    };
    const bool is_manifest = file.filename() == kManifestName;
    for (std::size_t i = 0; i < whole.size(); i += 1 + whole.size() / 50) {
      std::string changed = whole;
      changed[i] = static_cast<char>(changed[i] ^ 4);
      write(changed);
      EXPECT_TRUE(damage_is_found() || (is_manifest && (whole[i] == ' ' || whole[i] == '\n')))
          << file << " " << i;
    }
    write(whole.substr(0, whole.size() / 2));
    EXPECT_TRUE(damage_is_found()) << file;
    write(whole + "x");
    EXPECT_TRUE(damage_is_found()) << file;
    fs::remove(file);
    EXPECT_TRUE(damage_is_found()) << file;
    write(whole);
    EXPECT_FALSE(damage_is_found()) << file;
  }
}

TEST(ConvertDataset, RefusesADamagedFileAndLeavesNoManifest) {
  const TemporaryFolder folder;
  const fs::path file = prepared_file(folder, {"noise", fields::noise({20, 20, 20}, 1)}, "noise");
  std::string bytes = bytes_of_file(file);
  bytes[5000] = static_cast<char>(bytes[5000] ^ 1);
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_THROW(file_to_objects(file, folder.path() / "objects", false), DatasetFileError);
  EXPECT_FALSE(is_object_dataset((folder.path() / "objects").string()));
}

TEST(ObjectDataset, SaysWhereThereIsNone) {
  const TemporaryFolder folder;
  try {
    (void)open_objects(folder.path().string(), small_cache());
    FAIL();
  } catch (const DatasetFileError& error) {
    EXPECT_NE(std::string(error.what()).find("no manifest.json"), std::string::npos);
  }
}

}  // namespace
}  // namespace multitetra
