#include "server/store/memory_cache.hpp"

#include <utility>

namespace multitetra {

MemoryCache::Owner::Owner(MemoryCache& cache)
    : cache_(cache), number_([] {
        static std::atomic<std::uint64_t> last = 0;
        return ++last;
      }()) {}

MemoryCache::Owner::~Owner() { cache_.remove_all_of(number_); }

MemoryCache::MemoryCache(std::size_t max_bytes) : max_bytes_(max_bytes) {
  for (Shard& shard : shards_) shard.entries = LruMap<Key, CachedBytes>(max_bytes / shards_.size());
}

MemoryCache::Shard& MemoryCache::shard_of(const Key& key) {
  const std::uint64_t mixed = (key.item + key.owner * 0x9e3779b97f4a7c15u) * 0xff51afd7ed558ccdu;
  return shards_[(mixed ^ mixed >> 32) / 64 % shards_.size()];
}

CachedBytes MemoryCache::find(const Key& key) {
  Shard& shard = shard_of(key);
  const std::lock_guard lock(shard.mutex);
  const CachedBytes* const found = shard.entries.find(key);
  return found != nullptr ? *found : nullptr;
}

void MemoryCache::put(const Key& key, CachedBytes bytes) {
  Shard& shard = shard_of(key);
  const std::size_t size = bytes->size();
  LruMap<Key, CachedBytes>::Evicted evicted;  // Destroyed after the lock is released.
  const std::lock_guard lock(shard.mutex);
  evicted = shard.entries.add(key, std::move(bytes), size);
  shard.evictions += evicted.size();
}

void MemoryCache::remove(const Key& key) {
  Shard& shard = shard_of(key);
  const std::lock_guard lock(shard.mutex);
  shard.entries.remove(key);
}

void MemoryCache::remove_all_of(std::uint64_t owner) {
  for (Shard& shard : shards_) {
    const std::lock_guard lock(shard.mutex);
    shard.entries.remove_between({.owner = owner, .item = 0}, {.owner = owner + 1, .item = 0});
  }
}

MemoryCache::Counts MemoryCache::counts() const {
  Counts counts;
  for (const Shard& shard : shards_) {
    const std::lock_guard lock(shard.mutex);
    counts.evictions += shard.evictions;
    counts.bytes += shard.entries.weight();
  }
  return counts;
}

}  // namespace multitetra
