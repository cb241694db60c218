#include "server/store/memory_cache.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <vector>

namespace multitetra {
namespace {

CachedBytes bytes_of_size(std::size_t size, int value) {
  return std::make_shared<const std::vector<std::byte>>(size, static_cast<std::byte>(value));
}

TEST(MemoryCache, ReturnsOnlyBytesOfTheSameKey) {
  MemoryCache cache(1 << 20);
  cache.put({1, 7}, bytes_of_size(10, 1));
  cache.put({2, 7}, bytes_of_size(10, 2));
  EXPECT_EQ(cache.find({1, 7})->front(), std::byte{1});
  EXPECT_EQ(cache.find({2, 7})->front(), std::byte{2});
  EXPECT_EQ(cache.find({1, 8}), nullptr);
  cache.put({1, 7}, bytes_of_size(20, 3));
  EXPECT_EQ(cache.find({1, 7})->size(), 20U);
  EXPECT_EQ(cache.counts().bytes, 30U);
  cache.remove({1, 7});
  EXPECT_EQ(cache.find({1, 7}), nullptr);
  EXPECT_EQ(cache.counts().bytes, 10U);
}

TEST(MemoryCache, EvictsTheLeastRecentlyUsedEntries) {
  MemoryCache cache(16 * 1000);
  const CachedBytes kept = bytes_of_size(100, 9);
  cache.put({1, 0}, kept);
  for (std::uint64_t i = 1; i < 1000; ++i) {
    EXPECT_NE(cache.find({1, 0}), nullptr) << i;  // The entry that is always in use.
    cache.put({1, i}, bytes_of_size(100, 1));
    EXPECT_LE(cache.counts().bytes, 16U * 1000U);
  }
  EXPECT_GT(cache.counts().evictions, 800U);
  EXPECT_EQ(cache.find({1, 1}), nullptr);
}

TEST(MemoryCache, RemovesTheEntriesOfADestroyedOwner) {
  MemoryCache cache(1 << 20);
  const MemoryCache::Owner kept(cache);
  std::optional<MemoryCache::Owner> gone(std::in_place, cache);
  for (std::uint64_t i = 0; i < 100; ++i) {
    cache.put(kept.key(i), bytes_of_size(10, 1));
    cache.put(gone->key(i), bytes_of_size(10, 2));
  }
  const CachedBytes in_use = cache.find(gone->key(7));
  const MemoryCache::Key key = gone->key(7);
  gone.reset();
  EXPECT_EQ(cache.find(key), nullptr);
  EXPECT_EQ(in_use->front(), std::byte{2});
  EXPECT_EQ(cache.counts().bytes, 1000U);
  EXPECT_EQ(cache.counts().evictions, 0U);
  EXPECT_EQ(cache.find(kept.key(7))->front(), std::byte{1});
}

TEST(MemoryCache, KeepsFoundBytesAfterEviction) {
  MemoryCache cache(0);
  const CachedBytes bytes = bytes_of_size(100, 5);
  cache.put({1, 1}, bytes);
  EXPECT_EQ(cache.find({1, 1}), nullptr);
  EXPECT_EQ(bytes->back(), std::byte{5});
}

TEST(MemoryCache, IsThreadSafe) {
  MemoryCache cache(64 << 10);
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&cache, t] {
      for (int i = 0; i < 5000; ++i) {
        const std::uint64_t item = static_cast<std::uint64_t>(i * (t + 1) % 300);
        const CachedBytes found = cache.find({1, item});
        if (found) {
          EXPECT_EQ(found->front(), static_cast<std::byte>(item));
        } else {
          cache.put({1, item}, bytes_of_size(1000, static_cast<int>(item)));
        }
      }
    });
  }
}

}  // namespace
}  // namespace multitetra
