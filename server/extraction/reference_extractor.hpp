// The isosurface of a dataset by the reference method: exact errors of one isovalue, from a pass
// over the volume. For comparison with the error spectrum, uniform levels, and files of models.
#pragma once

#include <memory>
#include <stop_token>

#include "server/core/errors/error_based_model.hpp"
#include "server/core/framework/field.hpp"
#include "server/core/planning/resolved_step.hpp"
#include "server/core/surface/tiling.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// Resolves a step. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] ResolvedStep resolved_step(const StepRequest& step, const DatasetInfo& info,
                                         const std::stop_token& stop = {});

// Holds the whole volume in memory.
class ReferenceExtractor {
 public:
  // The dataset must outlive the extractor.
  explicit ReferenceExtractor(const PreparedVolume& dataset);
  ReferenceExtractor(const ReferenceExtractor&) = delete;
  ReferenceExtractor& operator=(const ReferenceExtractor&) = delete;

  [[nodiscard]] const Field& field() const { return field_; }

  // Returns the model with exact errors, after a pass over the volume.
  [[nodiscard]] std::shared_ptr<const Model> exact_model(const ResolvedStep& spec,
                                                         std::stop_token stop = {}) const;
  // Returns the model that SurfaceExtractor extracts, which takes coarse errors from the spectrum.
  // Requires a grid of more than kSpectrumSpacing steps a side.
  [[nodiscard]] std::shared_ptr<const Model> spectrum_model(const ResolvedStep& spec,
                                                            std::stop_token stop = {}) const;

  // Returns the surface of any model of this grid. Throws Cancelled soon after `stop` is triggered.
  // With `take`, its tiles are passed to it instead.
  [[nodiscard]] TiledMesh surface(const Model& model, const SurfaceOptions& options,
                                  std::stop_token stop = {}, const TakeTile& take = nullptr) const;
  // Return the surface of a step, simplified if the step requests it, from a model of the step or,
  // without one, from the model with exact errors.
  [[nodiscard]] TiledMesh extract(const ResolvedStep& spec, const Model& model,
                                  std::stop_token stop = {}) const;
  [[nodiscard]] TiledMesh extract(const ResolvedStep& spec, std::stop_token stop = {}) const;

 private:
  const PreparedVolume& dataset_;
  Volume volume_;
  Field field_;
};

}  // namespace multitetra
