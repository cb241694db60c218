// The isosurface of a dataset by the reference way: exact errors of one isovalue, from a pass over
// the whole volume. For comparison with the error spectrum, for uniform levels, and for models that
// are written to files.
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

// What follows from a step. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] ResolvedStep resolved_step(const StepRequest& step, const DatasetInfo& info,
                                         const std::stop_token& stop = {});

// Holds the whole volume in memory.
class ReferenceExtractor {
 public:
  // The dataset must outlive it.
  explicit ReferenceExtractor(const PreparedVolume& dataset);
  ReferenceExtractor(const ReferenceExtractor&) = delete;
  ReferenceExtractor& operator=(const ReferenceExtractor&) = delete;

  [[nodiscard]] const Field& field() const { return field_; }

  // The model with exact errors, after a pass over the volume.
  [[nodiscard]] std::shared_ptr<const Model> exact_model(const ResolvedStep& spec,
                                                         std::stop_token stop = {}) const;
  // The model that SurfaceExtractor shows: with errors from the spectrum where it has them.
  // Requires a grid of more than kSpectrumSpacing steps a side.
  [[nodiscard]] std::shared_ptr<const Model> spectrum_model(const ResolvedStep& spec,
                                                            std::stop_token stop = {}) const;

  // The isosurface of any model of this grid. Throws Cancelled soon after `stop` is triggered.
  [[nodiscard]] TiledSurface surface(const Model& model, const SurfaceOptions& options,
                                     std::stop_token stop = {}) const;
  // The surface of a step, simplified if the step says so, from a model of the step; without one
  // from the model with exact errors.
  [[nodiscard]] TiledSurface extract(const ResolvedStep& spec, const Model& model,
                                     std::stop_token stop = {}) const;
  [[nodiscard]] TiledSurface extract(const ResolvedStep& spec, std::stop_token stop = {}) const;

 private:
  const PreparedVolume& dataset_;
  Volume volume_;
  Field field_;
};

}  // namespace multitetra
