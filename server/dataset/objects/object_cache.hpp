// The objects of datasets, as whoever reads bricks gets them: from memory, from a folder of this
// machine, or from their store; and those that will be needed, fetched meanwhile.
//
//   ObjectCache cache({.memory_bytes = 512 << 20, .folder = "/var/cache/multitetra"});
//   cache.will_need(place, names);
//   const ObjectBytes first = cache.get(place, names[0]);
//
// Guaranteed: the bytes are those of the name. They stay as long as somebody keeps them; memory is
// bounded by memory_bytes, and what is in use. An object that several ask for is fetched once.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/dataset/objects/object_disk_cache.hpp"
#include "server/dataset/objects/object_name.hpp"
#include "server/store/http_store.hpp"

namespace multitetra {

struct ObjectCacheOptions {
  std::size_t memory_bytes = std::size_t{512} << 20;
  std::filesystem::path folder = {};  // For objects from far away; empty: none.
  std::uint64_t folder_bytes = std::uint64_t{16} << 30;
  std::size_t fetchers = 8;  // Threads that fetch what will be needed.
  HttpStoreOptions far = {};
};

// Where the objects of a dataset are.
struct ObjectPlace {
  std::string place;  // A folder or an address.
  std::shared_ptr<ObjectStore> store;
  bool is_far = false;
};

using ObjectBytes = std::shared_ptr<const std::vector<std::byte>>;

// Safe to use from several threads at once.
class ObjectCache {
 public:
  // Throws std::filesystem::filesystem_error when the folder cannot be made.
  explicit ObjectCache(const ObjectCacheOptions& options = {});
  ~ObjectCache();
  ObjectCache(const ObjectCache&) = delete;
  ObjectCache& operator=(const ObjectCache&) = delete;

  // A folder, or an address as of http_store(). Throws StoreError for an address that is none.
  [[nodiscard]] ObjectPlace place(const std::string& place) const;

  // Throws StoreError when the store fails, DatasetFileError when what it has is not of this name.
  [[nodiscard]] ObjectBytes get(const ObjectPlace& place, const ObjectName& name);

  // Begins to fetch those that are not there, in this order, as far as they fit into half of the
  // memory. Does not wait, and never fails.
  void will_need(const ObjectPlace& place, std::span<const ObjectName> names);

  // How many bytes the objects have that are not in memory and not under way.
  [[nodiscard]] std::uint64_t missing_bytes(std::span<const ObjectName> names) const;

  struct Counts {
    std::uint64_t memory_hits = 0;
    std::uint64_t disk_hits = 0;
    std::uint64_t fetched = 0;  // From their stores,
    std::uint64_t fetched_bytes = 0;
    std::uint64_t retries = 0;       // Of requests to stores far away.
    std::uint64_t failures = 0;      // Objects that could not be had.
    std::uint64_t evictions = 0;     // From memory.
    std::uint64_t memory_bytes = 0;  // Now.
  };
  [[nodiscard]] Counts counts() const;

 private:
  struct Hash {
    std::size_t operator()(const ObjectName& name) const;
  };
  struct Kept {
    ObjectName name;
    ObjectBytes bytes;
  };
  struct Job {
    ObjectPlace place;
    ObjectName name;
  };
  [[nodiscard]] ObjectBytes fetched(const ObjectPlace& place, const ObjectName& name);
  void keep(const ObjectName& name, const ObjectBytes& bytes);
  void work(const std::stop_token& stop);

  const std::shared_ptr<std::atomic<std::uint64_t>> retries_;  // Stores may outlive the cache.
  const ObjectCacheOptions options_;
  std::unique_ptr<ObjectDiskCache> disk_;  // Null without a folder.

  mutable std::mutex mutex_;  // Guards what follows, but for the threads.
  std::list<Kept> kept_;      // The most recently used first.
  std::unordered_map<ObjectName, std::list<Kept>::iterator, Hash> index_;
  std::unordered_map<ObjectName, std::shared_future<ObjectBytes>, Hash> under_way_;
  Counts counts_;
  std::deque<Job> jobs_;
  std::size_t job_bytes_ = 0;
  std::condition_variable_any has_jobs_;
  std::vector<std::jthread> fetchers_;  // Last: they end before what they use.
};

}  // namespace multitetra
