// The allowed error at each place. Coordinates are in grid steps, thresholds in world units.
//
//   const ThresholdMap thresholds(request, info);
//   kept = error > thresholds.least_in(region(point));
//
// least_in is a lower bound of the thresholds at all places of the box, exact where the map's parts
// are parallel to the grid and their borders do not cross inside the box. It is *monotone*, bit for
// bit: for a box inside another it is never smaller. Models conform because of this: the region of
// a child lies inside that of its parents, so a kept point has kept parents. threshold_bound.hpp
// explains why this also holds in floating point.
//
// Boxes are first clamped to the extent of the samples, which keeps nested boxes nested.
#pragma once

#include <cassert>
#include <functional>
#include <memory>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

// Immutable and cheap to copy; safe to use from several threads at once.
class ThresholdMap {
 public:
  // Returns a map with the same threshold everywhere. World units, >= 0.
  [[nodiscard]] static ThresholdMap everywhere(double threshold) {
    assert(threshold >= 0);
    return ThresholdMap(threshold, threshold);
  }

  // Builds the map of a validated request. This takes long for very many regions; `check`, if set,
  // is called repeatedly meanwhile and may throw.
  ThresholdMap(const IsosurfaceRequest& request, const DatasetInfo& info,
               const std::function<void()>& check = {});

  // Returns a finite lower bound of the thresholds in `box`.
  [[nodiscard]] double least_in(const Box& box) const {
    return parts_ ? least_of_parts(box) : least_;
  }

  // Bounds of least_in over all boxes.
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  struct IndexedParts;

  ThresholdMap(double least, double largest) : least_(least), largest_(largest) {}
  [[nodiscard]] double least_of_parts(const Box& box) const;

  double least_;
  double largest_;
  std::shared_ptr<const IndexedParts> parts_;  // Null if the threshold is the same everywhere.
};

// Returns ThresholdMap(request, info).largest() without building the index for queries: a bound of
// the error that the request allows anywhere.
[[nodiscard]] double largest_threshold(const IsosurfaceRequest& request, const DatasetInfo& info);

}  // namespace multitetra
