#include "server/store/memory_cache.hpp"

#include <utility>

namespace multitetra {

MemoryCache::Owner::Owner(MemoryCache& cache)
    : cache_(cache), number_([] {
        static std::atomic<std::uint64_t> last = 0;
        return ++last;
      }()) {}

MemoryCache::Owner::~Owner() { cache_.remove_all_of(number_); }

CachedBytes MemoryCache::find(const Key& key) {
  Shard& shard = shard_of(key);
  const std::lock_guard lock(shard.mutex);
  const auto found = shard.index.find(key);
  if (found == shard.index.end()) return nullptr;
  shard.entries.splice(shard.entries.begin(), shard.entries, found->second);
  return found->second->bytes;
}

void MemoryCache::put(const Key& key, CachedBytes bytes) {
  Shard& shard = shard_of(key);
  std::list<Entry> removed;  // Freed without the lock.
  const std::lock_guard lock(shard.mutex);
  if (const auto found = shard.index.find(key); found != shard.index.end()) {
    remove_entry(shard, found->second);
  }
  shard.bytes += bytes->size();
  shard.entries.push_front({key, std::move(bytes)});
  shard.index[key] = shard.entries.begin();
  while (shard.bytes > most_bytes_ / shards_.size()) {
    const auto last = std::prev(shard.entries.end());
    shard.bytes -= last->bytes->size();
    shard.index.erase(last->key);
    removed.splice(removed.begin(), shard.entries, last);
    ++shard.evictions;
  }
}

void MemoryCache::remove(const Key& key) {
  Shard& shard = shard_of(key);
  const std::lock_guard lock(shard.mutex);
  if (const auto found = shard.index.find(key); found != shard.index.end()) {
    remove_entry(shard, found->second);
  }
}

void MemoryCache::remove_all_of(std::uint64_t owner) {
  for (Shard& shard : shards_) {
    const std::lock_guard lock(shard.mutex);
    for (auto entry = shard.entries.begin(); entry != shard.entries.end();) {
      const auto next = std::next(entry);
      if (entry->key.owner == owner) remove_entry(shard, entry);
      entry = next;
    }
  }
}

void MemoryCache::remove_entry(Shard& shard, std::list<Entry>::iterator entry) {
  shard.bytes -= entry->bytes->size();
  shard.index.erase(entry->key);
  shard.entries.erase(entry);
}

MemoryCache::Counts MemoryCache::counts() const {
  Counts counts;
  for (const Shard& shard : shards_) {
    const std::lock_guard lock(shard.mutex);
    counts.evictions += shard.evictions;
    counts.bytes += shard.bytes;
  }
  return counts;
}

}  // namespace multitetra
