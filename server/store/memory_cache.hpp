// A memory cache of byte arrays. Evicts the least recently used ones above its limit.
//
//   MemoryCache cache(std::size_t{512} << 20);
//   const MemoryCache::Owner owner(cache);
//   cache.put(owner.key(7), bytes);
//   if (const CachedBytes found = cache.find(owner.key(7))) ...
//
// Guaranteed: returned bytes stay valid while the caller holds them; memory is bounded by the limit
// plus the bytes in use. Threads with different keys rarely contend.
#pragma once

#include <array>
#include <atomic>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "common/base/lru_map.hpp"

namespace multitetra {

using CachedBytes = std::shared_ptr<const std::vector<std::byte>>;

// Safe to use from several threads at once.
class MemoryCache {
 public:
  struct Key {
    std::uint64_t owner = 0;
    std::uint64_t item = 0;

    friend auto operator<=>(const Key&, const Key&) = default;
  };

  // A user of the cache, with keys of its own. Destroying it removes its entries, such as those of
  // a dataset that was replaced. The cache must outlive it.
  class Owner {
   public:
    explicit Owner(MemoryCache& cache);
    ~Owner();
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;

    [[nodiscard]] Key key(std::uint64_t item) const { return {.owner = number_, .item = item}; }

   private:
    MemoryCache& cache_;
    const std::uint64_t number_;
  };

  explicit MemoryCache(std::size_t max_bytes);

  // Returns null if the key is not cached.
  [[nodiscard]] CachedBytes find(const Key& key);
  void put(const Key& key, CachedBytes bytes);
  void remove(const Key& key);

  [[nodiscard]] std::size_t max_bytes() const { return max_bytes_; }

  struct Counts {
    std::uint64_t evictions = 0;
    std::uint64_t bytes = 0;  // Currently cached.
  };
  [[nodiscard]] Counts counts() const;

 private:
  struct Shard {
    mutable std::mutex mutex;  // Guards the following members.
    LruMap<Key, CachedBytes> entries{0};
    std::uint64_t evictions = 0;
  };
  [[nodiscard]] Shard& shard_of(const Key& key);
  void remove_all_of(std::uint64_t owner);

  const std::size_t max_bytes_;
  std::array<Shard, 16> shards_;
};

}  // namespace multitetra
