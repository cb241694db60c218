// The error-based model of a prepared volume for one request: the same predicate as
// ErrorBasedModel, with errors from the spectrum and, below its spacing, from the samples.
#pragma once

#include <memory>
#include <utility>

#include "common/mesh/octree_cube.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/fine_errors/fine_errors.hpp"
#include "server/core/framework/tetrahedron.hpp"
#include "server/core/spectrum/error_spectrum.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Immutable and thread-safe. Conforms for any threshold map: the spectrum is never smaller than the
// exact errors used below it, so a kept point has kept parents.
class PreparedModel {
 public:
  // The volume must outlive the model. Requires a grid of more than kSpectrumSpacing steps a side.
  // `spectrum` may be shared by models of the same isovalue, measure and rule, which then decode
  // its bricks once; if null, the model creates its own.
  PreparedModel(const PreparedVolume& volume, const FineErrorsOptions& errors, ModelOptions options,
                std::shared_ptr<const SpectrumErrors> spectrum = nullptr)
      : volume_(volume),
        fine_(errors),
        options_(std::move(options)),
        spectrum_(spectrum ? std::move(spectrum)
                           : std::make_shared<const SpectrumErrors>(
                                 volume, errors.isovalue, errors.error_measure, errors.rule)) {
    fine_.largest_threshold = options_.thresholds.largest();
    fine_.finest_spacing = options_.finest_spacing;
  }

  [[nodiscard]] const PreparedVolume& volume() const { return volume_; }
  [[nodiscard]] const ThresholdMap& thresholds() const { return options_.thresholds; }
  [[nodiscard]] const FineErrorsOptions& fine_options() const { return fine_; }

  // Returns whether a point of spacing kSpectrumSpacing or more is kept. Does not look up points
  // below the finest spacing, as their bricks may be remote.
  [[nodiscard]] bool kept(const DividingPoint& point) const {
    return may_keep(point.spacing()) && options_.keeps(point, spectrum_->bound(point));
  }

  // Returns whether a finer point p of spacing s is kept. Requires its error, which is infinite if
  // a flip keeps the point.
  [[nodiscard]] bool kept(GridPoint p, std::int32_t s, float error) const {
    return s >= options_.finest_spacing &&
           options_.is_exceeded_by(error, [&] { return region(DividingPoint(p)); });
  }

  // Returns whether points of spacing s may be kept at all.
  [[nodiscard]] bool may_keep(std::int32_t s) const { return s >= options_.finest_spacing; }
  // Returns whether the threshold is the same everywhere. Then a finer point is kept exactly if its
  // error exceeds the largest threshold, and no exact value is needed.
  [[nodiscard]] bool has_one_threshold() const {
    return options_.thresholds.least() == options_.thresholds.largest();
  }

  // Returns whether the cell's center may be kept, that is, whether all its parents are.
  [[nodiscard]] bool is_wanted(const OctreeCube& cell) const {
    if (options_.finest_spacing >= kSpectrumSpacing) return false;
    const PointList<4> parents = center(cell).parents(Grid(volume_.info.grid_exponent));
    for (const GridPoint parent : parents) {
      if (!kept(DividingPoint(parent))) return false;
    }
    return true;
  }

 private:
  const PreparedVolume& volume_;
  FineErrorsOptions fine_;
  ModelOptions options_;
  std::shared_ptr<const SpectrumErrors> spectrum_;
};

}  // namespace multitetra
