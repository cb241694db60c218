// The exact errors of the isovalues asked for last, of all datasets that share the cache.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <tuple>

#include "common/isosurface_request.hpp"
#include "server/core/field.hpp"
#include "server/core/saturated_errors.hpp"

namespace multitetra {

// Equal requests share one computation, and who waits for another's can be stopped. Safe to use
// from several threads at once.
class ErrorsCache {
 public:
  // What was used least recently is dropped while more than `max_bytes` are kept, but the last one
  // always stays.
  explicit ErrorsCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  // `field` must outlive the cache. Throws Cancelled soon after `stop` is triggered.
  [[nodiscard]] std::shared_ptr<const SaturatedErrors> get(const Field& field,
                                                           const IsosurfaceRequest& request,
                                                           std::stop_token stop);

 private:
  using Key = std::tuple<const Field*, double, ErrorMeasure, TopologyRule>;
  struct Entry {
    Key key;
    std::shared_ptr<const SaturatedErrors> errors;
  };
  // Null when they are not kept; otherwise they are the last to be dropped. Requires mutex_.
  std::shared_ptr<const SaturatedErrors> find(const Key& key);
  void keep(const Key& key, std::shared_ptr<const SaturatedErrors> errors);

  const std::size_t max_bytes_;
  std::mutex mutex_;  // Guards all below.
  std::condition_variable_any changed_;
  std::set<Key> computing_;
  std::list<Entry> recent_;  // Used last first.
  std::size_t bytes_ = 0;    // Of recent_.
};

}  // namespace multitetra
