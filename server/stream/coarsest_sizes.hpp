// The sizes of coarsest surfaces that exceeded a budget, so that further budgets that are too small
// are refused without making the surface again.
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/lru_map.hpp"
#include "common/request/request_key.hpp"
#include "server/core/planning/refinement_plan.hpp"

namespace multitetra {

struct CoarsestSizes {
  // The size with the topology that the request requires. Meshes have no bytes.
  SurfaceSize kept;
  // Estimates for topology tolerances of 2^0, 2^1, ... voxels, as far as they were needed.
  std::vector<SurfaceSize> tolerant = {};
};

// Caches sizes for one dataset. The key is the request without its budgets. Thread-safe.
class CoarsestSizesCache {
 public:
  [[nodiscard]] std::optional<CoarsestSizes> find(const IsosurfaceRequest& request) {
    const std::lock_guard lock(mutex_);
    const CoarsestSizes* const found = sizes_.find(key(request));
    return found ? std::optional(*found) : std::nullopt;
  }
  void keep(const IsosurfaceRequest& request, CoarsestSizes sizes) {
    const std::lock_guard lock(mutex_);
    std::string by = key(request);
    const std::size_t weight = sizeof(CoarsestSizes) + 2 * by.size();  // The map keeps it twice.
    sizes_.add(std::move(by), std::move(sizes), weight);
  }

 private:
  static std::string key(IsosurfaceRequest request) {
    request.max_triangles = request.max_bytes = 0;
    return key_of(request);
  }

  std::mutex mutex_;
  LruMap<std::string, CoarsestSizes> sizes_{std::size_t{1} << 20};  // Bytes.
};

}  // namespace multitetra
