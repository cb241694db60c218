#include "server/service/errors_cache.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "server/dataset/in_parallel.hpp"

namespace multitetra {

std::shared_ptr<const SaturatedErrors> ErrorsCache::get(const Field& field,
                                                        const IsosurfaceRequest& request,
                                                        std::stop_token stop) {
  const Key key(&field, request.isovalue, request.measure, request.topology_rule);
  std::unique_lock lock(mutex_);
  if (!changed_.wait(lock, stop, [&] { return !computing_.contains(key); })) throw Cancelled{};
  if (const auto known = find(key)) return known;

  computing_.insert(key);
  lock.unlock();
  std::shared_ptr<const SaturatedErrors> errors;
  std::exception_ptr trouble;
  try {
    const ForEach for_each = [&](std::size_t count, const std::function<void(std::size_t)>& body) {
      in_parallel(count, body, stop);
    };
    errors = std::make_shared<const SaturatedErrors>(field, request.isovalue, request.measure,
                                                     request.topology_rule, for_each);
  } catch (...) {
    trouble = std::current_exception();
  }
  lock.lock();
  computing_.erase(key);
  changed_.notify_all();
  if (trouble) std::rethrow_exception(trouble);
  keep(key, errors);
  return errors;
}

std::shared_ptr<const SaturatedErrors> ErrorsCache::find(const Key& key) {
  const auto found =
      std::find_if(recent_.begin(), recent_.end(), [&](const Entry& e) { return e.key == key; });
  if (found == recent_.end()) return nullptr;
  recent_.splice(recent_.begin(), recent_, found);
  return recent_.front().errors;
}

void ErrorsCache::keep(const Key& key, std::shared_ptr<const SaturatedErrors> errors) {
  bytes_ += errors->bytes();
  recent_.push_front({key, std::move(errors)});
  while (bytes_ > max_bytes_ && recent_.size() > 1) {
    bytes_ -= recent_.back().errors->bytes();
    recent_.pop_back();
  }
}

}  // namespace multitetra
