#include "server/dataset/objects/object_cache.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> object_bytes(int which, std::size_t size = 1000) {
  std::vector<std::byte> bytes(size, static_cast<std::byte>(which));
  bytes[0] = static_cast<std::byte>(which >> 8);
  return bytes;
}

// Counts what is asked, and lies when it shall.
class StrangeStore : public ObjectStore {
 public:
  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t) override {
    ++asked;
    if (fails) throw StoreError(key, "it fails", "Wait");
    auto bytes = objects.at(key);
    if (lies > 0) {
      --lies;
      bytes[5] ^= std::byte{1};
    }
    return is_empty ? std::nullopt : std::optional(bytes);
  }
  std::optional<std::vector<std::byte>> get_range(const std::string&, std::uint64_t,
                                                  std::uint64_t) override {
    return std::nullopt;
  }
  [[nodiscard]] fs::path place(const std::string& key) const override { return "strange/" + key; }
  [[nodiscard]] std::size_t parallel_requests() const override { return 1; }

  std::map<std::string, std::vector<std::byte>> objects;
  std::atomic<int> asked = 0;
  std::atomic<int> lies = 0;
  std::atomic<bool> fails = false;
  std::atomic<bool> is_empty = false;
};

class ObjectCacheTest : public ::testing::Test {
 protected:
  ObjectCacheTest() {
    for (int i = 0; i < 20; ++i) {
      names_.push_back(name_of(object_bytes(i)));
      store_->objects[names_.back().key()] = object_bytes(i);
    }
  }
  const std::shared_ptr<StrangeStore> store_ = std::make_shared<StrangeStore>();
  const ObjectPlace place_ = {.place = "strange", .store = store_, .is_far = true};
  std::vector<ObjectName> names_;
};

TEST_F(ObjectCacheTest, FetchesOnceAndForgetsWhatWasNotUsedForLongest) {
  ObjectCache cache({.memory_bytes = 3000});
  const ObjectBytes kept = cache.get(place_, names_[0]);
  for (const int i : {1, 2, 0, 3}) (void)cache.get(place_, names_[static_cast<std::size_t>(i)]);
  EXPECT_EQ(store_->asked, 4);
  (void)cache.get(place_, names_[0]);
  EXPECT_EQ(store_->asked, 4);
  (void)cache.get(place_, names_[1]);
  EXPECT_EQ(store_->asked, 5);
  EXPECT_LE(cache.counts().memory_bytes, 3000U);
  for (const ObjectName& name : names_) (void)cache.get(place_, name);
  EXPECT_EQ(*kept, object_bytes(0));  // As long as somebody has it.
}

TEST_F(ObjectCacheTest, CountsWhereObjectsCameFromAndWhatBecameOfThem) {
  ObjectCache cache({.memory_bytes = 3000});
  for (const int i : {0, 0, 1, 2, 3}) (void)cache.get(place_, names_[static_cast<std::size_t>(i)]);
  store_->fails = true;
  EXPECT_THROW((void)cache.get(place_, names_[0]), StoreError);
  const ObjectCache::Counts counts = cache.counts();
  EXPECT_EQ(counts.memory_hits, 1U);
  EXPECT_EQ(counts.fetched, 4U);
  EXPECT_EQ(counts.fetched_bytes, 4000U);
  EXPECT_EQ(counts.evictions, 1U);
  EXPECT_EQ(counts.failures, 1U);
  EXPECT_EQ(counts.memory_bytes, 3000U);
}

TEST_F(ObjectCacheTest, TakesWrongBytesNever) {
  ObjectCache cache;
  store_->lies = 1;
  EXPECT_EQ(*cache.get(place_, names_[0]), object_bytes(0));
  store_->lies = 1000;
  EXPECT_THROW((void)cache.get(place_, names_[1]), DatasetFileError);
  store_->lies = 0;
  EXPECT_EQ(*cache.get(place_, names_[1]), object_bytes(1));
  store_->fails = true;
  EXPECT_THROW((void)cache.get(place_, names_[2]), StoreError);
  store_->fails = false;
  store_->is_empty = true;
  EXPECT_THROW((void)cache.get(place_, names_[2]), DatasetFileError);
}

TEST_F(ObjectCacheTest, KeepsObjectsOnDiskForTheNextStartAndForOthers) {
  const TemporaryFolder folder;
  const ObjectCacheOptions options{.folder = folder.path() / "cache"};
  for (int start = 0; start < 2; ++start) {
    ObjectCache cache(options);
    ObjectCache other(options);
    for (const ObjectName& name : names_) {
      EXPECT_EQ(*cache.get(place_, name), *other.get(place_, name));
    }
  }
  EXPECT_EQ(store_->asked, 20);
}

TEST_F(ObjectCacheTest, LooksAtWhatItFindsOnDisk) {
  const TemporaryFolder folder;
  const fs::path cached = folder.path() / names_[0].key();
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{10}, std::size_t{1000}, std::size_t{9999}}) {
    (void)ObjectCache({.folder = folder.path()}).get(place_, names_[0]);
    ASSERT_TRUE(fs::exists(cached));
    std::ofstream(cached, std::ios::binary | std::ios::trunc) << std::string(size, 'x');
    EXPECT_EQ(*ObjectCache({.folder = folder.path()}).get(place_, names_[0]), object_bytes(0));
    EXPECT_EQ(bytes_of_file(cached).size(), 1000U);
  }
}

TEST_F(ObjectCacheTest, NeverFillsTheDiskBeyondItsLimit) {
  const TemporaryFolder folder;
  ObjectCache cache({.memory_bytes = 1, .folder = folder.path(), .folder_bytes = 8000});
  for (const ObjectName& name : names_) {
    (void)cache.get(place_, name);
    std::uint64_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.is_regular_file()) bytes += entry.file_size();
    }
    EXPECT_LE(bytes, 8000U);
  }
}

TEST_F(ObjectCacheTest, FetchesAheadWithoutWaiting) {
  ObjectCache cache;
  cache.will_need(place_, names_);
  while (store_->asked < 20) std::this_thread::yield();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    EXPECT_EQ(*cache.get(place_, names_[i]), object_bytes(static_cast<int>(i)));
  }
  EXPECT_EQ(store_->asked, 20);
}

TEST_F(ObjectCacheTest, AsksOnceForWhatManyThreadsWant) {
  ObjectCache cache({.memory_bytes = 1 << 20, .fetchers = 2});
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        cache.will_need(place_, names_);
        for (const ObjectName& name : names_) (void)cache.get(place_, name);
      });
    }
  }
  EXPECT_EQ(store_->asked, 20);
}

TEST_F(ObjectCacheTest, EndsWhileItFetchesAhead) {
  for (int i = 0; i < 20; ++i) {
    ObjectCache cache({.memory_bytes = 1 << 20, .fetchers = 3});
    cache.will_need(place_, names_);
  }
}

}  // namespace
}  // namespace multitetra
