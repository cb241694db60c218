// The surfaces of a local dataset: extracts and encodes them, or takes them from the cache.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>

#include "server/service/detail/single_flight.hpp"
#include "server/service/surface_cache.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

class SurfaceExtractor;

class CachingSurfaceProvider : public SurfaceProvider {
 public:
  // Providers that share a cache need datasets of different names. Null: no cache.
  explicit CachingSurfaceProvider(std::shared_ptr<const SurfaceExtractor> extractor,
                                  std::shared_ptr<SurfaceCache> cache = nullptr);

  [[nodiscard]] const DatasetInfo& info() const override;
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override;
  // Does not cache the meshes; returns encoded tiles if the cache has them. Concurrent equal
  // requests share one extraction.
  [[nodiscard]] EncodedStep make_meshes(const StepRequest& step,
                                        std::stop_token stop) const override;
  [[nodiscard]] bool is_cached(const StepRequest& step) const override;
  [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const override;
  [[nodiscard]] CostEstimates costs() const override;
  [[nodiscard]] const PreparedVolume* volume() const override;

 private:
  enum class TileForm { kEncoded, kMesh };
  [[nodiscard]] EncodedStep extract(const StepRequest& step, TileForm form,
                                    const std::stop_token& stop) const;
  [[nodiscard]] EncodedStep extract_in_shells(const StepRequest& step,
                                              const std::stop_token& stop) const;
  using Clock = std::chrono::steady_clock;
  void record_costs(const StepRequest& step, const EncodedStep& made,
                    Clock::time_point start) const;

  std::shared_ptr<const SurfaceExtractor> extractor_;
  std::shared_ptr<SurfaceCache> cache_;
  mutable SingleFlight<std::string, EncodedStep> meshes_;
  mutable std::mutex costs_mutex_;
  mutable MeasuredCosts costs_;  // Guarded by costs_mutex_.
};

}  // namespace multitetra
