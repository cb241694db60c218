#include "server/dataset/objects/object_cache.hpp"

#include <cstring>
#include <exception>
#include <utility>

#include "server/dataset/byte_source.hpp"

namespace multitetra {
namespace {

bool is_named(const std::vector<std::byte>& bytes, const ObjectName& name) {
  return bytes.size() == name.size && name_of(bytes) == name;
}

ObjectCacheOptions counting(ObjectCacheOptions options,
                            std::shared_ptr<std::atomic<std::uint64_t>> retries) {
  options.far.tries_again = [retries = std::move(retries), told = options.far.tries_again] {
    ++*retries;
    if (told) told();
  };
  return options;
}

}  // namespace

std::size_t ObjectCache::Hash::operator()(const ObjectName& name) const {
  std::size_t hash = 0;
  std::memcpy(&hash, name.digest.data(), sizeof(hash));
  return hash;
}

ObjectCache::ObjectCache(const ObjectCacheOptions& options)
    : retries_(std::make_shared<std::atomic<std::uint64_t>>(0)),
      options_(counting(options, retries_)) {
  if (!options_.folder.empty()) {
    disk_ = std::make_unique<ObjectDiskCache>(options_.folder, options_.folder_bytes);
  }
}

ObjectCache::~ObjectCache() {
  for (std::jthread& fetcher : fetchers_) fetcher.request_stop();
  has_jobs_.notify_all();
}

ObjectPlace ObjectCache::place(const std::string& place) const {
  const bool is_far = is_address(place);
  return {.place = place,
          .store = is_far ? http_store(place, options_.far) : folder_store(place),
          .is_far = is_far};
}

ObjectBytes ObjectCache::get(const ObjectPlace& place, const ObjectName& name) {
  std::promise<ObjectBytes> promise;
  {
    std::unique_lock lock(mutex_);
    if (const auto found = index_.find(name); found != index_.end()) {
      kept_.splice(kept_.begin(), kept_, found->second);
      ++counts_.memory_hits;
      return found->second->bytes;
    }
    const auto [at, is_first] = under_way_.try_emplace(name);
    if (!is_first) {
      const std::shared_future<ObjectBytes> other = at->second;
      lock.unlock();
      return other.get();
    }
    at->second = promise.get_future().share();
  }
  try {
    ObjectBytes bytes = fetched(place, name);
    {
      const std::lock_guard lock(mutex_);
      keep(name, bytes);
      under_way_.erase(name);
    }
    promise.set_value(bytes);
    return bytes;
  } catch (...) {
    {
      const std::lock_guard lock(mutex_);
      under_way_.erase(name);
      ++counts_.failures;
    }
    promise.set_exception(std::current_exception());
    throw;
  }
}

ObjectBytes ObjectCache::fetched(const ObjectPlace& place, const ObjectName& name) {
  ObjectDiskCache* const disk = place.is_far ? disk_.get() : nullptr;
  if (disk != nullptr) {
    if (auto bytes = disk->find(name)) {
      if (is_named(*bytes, name)) {
        const std::lock_guard lock(mutex_);
        ++counts_.disk_hits;
        return std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
      }
      disk->remove(name);
    }
  }
  const std::string key = name.key();
  // Bytes may be damaged on their way; what is wrong twice is wrong where it is.
  for (int attempt = 0; attempt < (place.is_far ? 2 : 1); ++attempt) {
    auto bytes = place.store->get(key, name.size);
    if (!bytes) {
      throw DatasetFileError(place.store->place(key),
                             "the object is missing. Convert the dataset again.");
    }
    if (!is_named(*bytes, name)) continue;
    if (disk != nullptr) disk->put(name, *bytes);
    const std::lock_guard lock(mutex_);
    ++counts_.fetched;
    counts_.fetched_bytes += bytes->size();
    return std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
  }
  throw DatasetFileError(place.store->place(key),
                         "its bytes are not those that its name tells. Convert the dataset again.");
}

// Requires the mutex.
void ObjectCache::keep(const ObjectName& name, const ObjectBytes& bytes) {
  kept_.push_front({name, bytes});
  index_[name] = kept_.begin();
  counts_.memory_bytes += name.size;
  while (counts_.memory_bytes > options_.memory_bytes) {
    counts_.memory_bytes -= kept_.back().name.size;
    index_.erase(kept_.back().name);
    kept_.pop_back();
    ++counts_.evictions;
  }
}

void ObjectCache::will_need(const ObjectPlace& place, std::span<const ObjectName> names) {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = 0;
  for (const ObjectName& name : names) {
    if (index_.contains(name) || under_way_.contains(name)) continue;
    bytes += name.size;
    if (bytes > options_.memory_bytes / 2) break;
    jobs_.push_back({place, name});
    job_bytes_ += name.size;
  }
  // What was wanted before, and never fetched, may not be wanted any more.
  while (job_bytes_ > options_.memory_bytes / 2) {
    job_bytes_ -= jobs_.front().name.size;
    jobs_.pop_front();
  }
  while (fetchers_.size() < std::min(options_.fetchers, jobs_.size())) {
    fetchers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
  has_jobs_.notify_all();
}

std::uint64_t ObjectCache::missing_bytes(std::span<const ObjectName> names) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const ObjectName& name : names) {
    if (!index_.contains(name) && !under_way_.contains(name)) bytes += name.size;
  }
  return bytes;
}

void ObjectCache::work(const std::stop_token& stop) {
  while (true) {
    std::unique_lock lock(mutex_);
    if (!has_jobs_.wait(lock, stop, [this] { return !jobs_.empty(); })) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    job_bytes_ -= job.name.size;
    if (index_.contains(job.name) || under_way_.contains(job.name)) continue;
    lock.unlock();
    try {
      (void)get(job.place, job.name);
    } catch (const std::exception&) {  // NOLINT: told to whoever needs it.
    }
  }
}

ObjectCache::Counts ObjectCache::counts() const {
  const std::lock_guard lock(mutex_);
  Counts counts = counts_;
  counts.retries = *retries_;
  return counts;
}

}  // namespace multitetra
