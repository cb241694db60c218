// Where a stream's steps come from: for sessions a dataset is what makes steps.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "common/wire/tile.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/extraction/surface_sizes.hpp"
#include "server/stream/step_cache.hpp"

namespace multitetra {

class SurfaceExtractor;

// Of all tiles together.
[[nodiscard]] SurfaceSize size_of(const EncodedStep& step);

// Immutable as seen from outside, and used by all sessions at once. What it takes long for throws
// Cancelled (of in_parallel.hpp) soon after `stop` is triggered.
class StepSource {
 public:
  virtual ~StepSource() = default;

  [[nodiscard]] virtual const DatasetInfo& info() const = 0;

  // Requires a validated request. The same step gives the same tiles, on any thread.
  [[nodiscard]] virtual EncodedStep make(const StepRequest& step, std::stop_token stop) const = 0;
  // Whether make() would have this step without making it, as far as can be told now.
  [[nodiscard]] virtual bool remembers(const StepRequest&) const { return false; }
  // How large steps would be; valid while the source lives.
  [[nodiscard]] virtual StepSizes sizes(std::stop_token stop, SizeAccuracy accuracy) const = 0;
  // What steps cost here, without the link.
  [[nodiscard]] virtual StepCosts costs() const { return {}; }
  // The samples, while the source lives; null where they are not here.
  [[nodiscard]] virtual const PreparedVolume* volume() const { return nullptr; }
};

// Steps that are extracted from the volume and encoded, unless the cache has them.
class ExtractedSteps : public StepSource {
 public:
  // Sources may share a cache; their datasets need different names then. Null: nothing is kept.
  explicit ExtractedSteps(std::shared_ptr<const SurfaceExtractor> extractor,
                          std::shared_ptr<StepCache> cache = nullptr);

  [[nodiscard]] const DatasetInfo& info() const override;
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override;
  [[nodiscard]] bool remembers(const StepRequest& step) const override;
  [[nodiscard]] StepSizes sizes(std::stop_token stop, SizeAccuracy accuracy) const override;
  [[nodiscard]] StepCosts costs() const override;
  [[nodiscard]] const PreparedVolume* volume() const override;

 private:
  [[nodiscard]] EncodedStep extract(const StepRequest& step, const std::stop_token& stop) const;

  std::shared_ptr<const SurfaceExtractor> extractor_;
  std::shared_ptr<StepCache> cache_;
  mutable std::mutex costs_mutex_;
  mutable LearnedCosts costs_;  // Guarded by costs_mutex_.
};

}  // namespace multitetra
