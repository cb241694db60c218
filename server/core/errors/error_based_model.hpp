// Models: selections of the framework's dividing points.
//
// A model is a predicate, not a data structure: it bisects a tetrahedron exactly when it keeps the
// tetrahedron's dividing point. A model is *conforming* (no vertex lies inside another
// tetrahedron's edge, so there are no cracks) exactly when every kept point has kept parents.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "server/core/errors/saturated_errors.hpp"
#include "server/core/framework/box.hpp"
#include "server/core/framework/dividing_point.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

class Model {
 public:
  virtual ~Model() = default;
  // Returns whether the model keeps the point. The center of the grid is always kept.
  [[nodiscard]] virtual bool kept(const DividingPoint& point) const = 0;
};

// Returns the box B(p) that a point influences. It contains every diamond of p and of its
// descendants, and B of a child lies inside B of its parents.
[[nodiscard]] inline Box region(const DividingPoint& point) {
  // Half-widths per axis: cube 3s; face 3s in its plane and 2s along its normal; edge 2s.
  const GridPoint p = point.at();
  const std::int32_t s = point.spacing();
  Box box{};
  for (int axis = 0; axis < 3; ++axis) {
    const bool in_face_plane = point.kind() == PointKind::kFace && (p[axis] & s) != 0;
    const bool wide = point.kind() == PointKind::kCube || in_face_plane;
    const std::int32_t half_width = (wide ? 3 : 2) * s;
    box.low[static_cast<std::size_t>(axis)] = p[axis] - half_width;
    box.high[static_cast<std::size_t>(axis)] = p[axis] + half_width;
  }
  return box;
}

struct ModelOptions {
  ThresholdMap thresholds = ThresholdMap::everywhere(0);
  double topology_tolerance = 0;  // In grid steps: flips of at most this spacing may be fused.
  // Points of a smaller spacing are fused.
  std::int32_t finest_spacing = 1;
  // Points of at least this spacing are kept, so every tetrahedron lies in an octree cube of at
  // most twice that side. A point's spacing is at most its parents', so the model conforms.
  std::int32_t refined_to = std::numeric_limits<std::int32_t>::max();

  // Here a threshold meets an error: returns whether `error` exceeds the least threshold in a
  // point's region. `region_of_point()` is called only if the result depends on it. `>` is strict:
  // at threshold 0, points that change nothing are fused.
  template <typename RegionOfPoint>
  [[nodiscard]] bool is_exceeded_by(float error, const RegionOfPoint& region_of_point) const {
    const auto e = static_cast<double>(error);
    return e > thresholds.least() &&
           (e > thresholds.largest() || e > thresholds.least_in(region_of_point()));
  }
  [[nodiscard]] bool keeps(const DividingPoint& point, const ErrorBound& bound) const {
    if (point.spacing() < finest_spacing) return false;
    if (point.spacing() >= refined_to) return true;
    return bound.flip_spacing > topology_tolerance ||
           is_exceeded_by(bound.error, [&] { return region(point); });
  }
};

// The paper's error-based model, for any threshold map.
class ErrorBasedModel final : public Model {
 public:
  ErrorBasedModel(std::shared_ptr<const SaturatedErrors> errors, ModelOptions options)
      : errors_(std::move(errors)), options_(std::move(options)) {}

  // A parent's error is at least that of its children, its region contains theirs and its spacing
  // is not smaller. So a kept point has kept parents: the model conforms without repair.
  [[nodiscard]] bool kept(const DividingPoint& point) const override {
    return options_.keeps(point, errors_->bound(point));
  }

 private:
  std::shared_ptr<const SaturatedErrors> errors_;
  ModelOptions options_;
};

// All tetrahedra of one depth from 0 to 3 N: the paper's "certain level".
class UniformModel final : public Model {
 public:
  UniformModel(const Grid& grid, int depth) : grid_(grid), depth_(depth) {}
  [[nodiscard]] bool kept(const DividingPoint& point) const override {
    return point.depth(grid_) < depth_;
  }

 private:
  Grid grid_;
  int depth_;
};

}  // namespace multitetra
