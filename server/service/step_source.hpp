// Where a stream's steps come from: for sessions a dataset is what makes steps.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "common/dataset_info.hpp"
#include "common/tile.hpp"
#include "server/core/refinement_plan.hpp"

namespace multitetra {

class SurfaceExtractor;

// A complete conforming model, ready to be sent.
struct EncodedStep {
  std::uint64_t tetrahedra = 0;         // Of the model.
  std::uint64_t active_tetrahedra = 0;  // Of them crossed by the surface.
  std::vector<EncodedTile> tiles;       // In the order they are sent.
};

// Immutable and used by all sessions at once.
class StepSource {
 public:
  virtual ~StepSource() = default;

  [[nodiscard]] virtual const DatasetInfo& info() const = 0;

  // Requires a validated request. The same step gives the same tiles, on any thread. Throws
  // Cancelled (of in_parallel.hpp) soon after `stop` is triggered.
  [[nodiscard]] virtual EncodedStep make(const StepRequest& step, std::stop_token stop) const = 0;
};

// Steps that are extracted from the volume and encoded, each time they are asked for.
class ExtractedSteps : public StepSource {
 public:
  explicit ExtractedSteps(std::shared_ptr<const SurfaceExtractor> extractor)
      : extractor_(std::move(extractor)) {}

  [[nodiscard]] const DatasetInfo& info() const override;
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override;

 private:
  std::shared_ptr<const SurfaceExtractor> extractor_;
};

}  // namespace multitetra
