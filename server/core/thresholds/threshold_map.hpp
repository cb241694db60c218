// What a request allows where: the largest error that is accepted at every place. Coordinates in
// grid steps, thresholds in world units.
//
//   const ThresholdMap thresholds(request, info);
//   kept = error > thresholds.least_in(region(point));
//
// least_in is a lower bound of the thresholds at all places of the box, exact where the map's parts
// are parallel to the grid and their borders do not cross inside the box. It is *monotone*, bit for
// bit: for a box inside another it is never smaller. The conformity of models rests on it: the
// region of a child lies inside that of its parents, so a point that the map keeps has parents that
// it keeps. Why it holds in floating point too stands in threshold_interval.hpp.
//
// Only places where the data are count: a box is moved into the samples' extent first, which keeps
// nested boxes nested.
#pragma once

#include <cassert>
#include <functional>
#include <memory>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

// Immutable and cheap to copy; safe to use from several threads at once.
class ThresholdMap {
 public:
  // The same threshold everywhere; world units, >= 0.
  [[nodiscard]] static ThresholdMap everywhere(double threshold) {
    assert(threshold >= 0);
    return ThresholdMap(threshold, threshold);
  }

  // The map of a validated request. With very many regions that takes long: `check`, if there is
  // one, is called again and again meanwhile and may throw.
  ThresholdMap(const IsosurfaceRequest& request, const DatasetInfo& info,
               const std::function<void()>& check = {});

  // The least threshold anywhere in `box`, or less. Finite.
  [[nodiscard]] double least_in(const Box& box) const {
    return parts_ ? least_of_parts(box) : least_;
  }

  // Bounds of least_in for every box, which need no look at the place.
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  struct Parts;

  ThresholdMap(double least, double largest) : least_(least), largest_(largest) {}
  [[nodiscard]] double least_of_parts(const Box& box) const;

  double least_;
  double largest_;
  std::shared_ptr<const Parts> parts_;  // None: the same everywhere.
};

// ThresholdMap(request, info).largest() without the work that queries need: a bound of the error
// that the request allows anywhere.
[[nodiscard]] double largest_threshold(const IsosurfaceRequest& request, const DatasetInfo& info);

}  // namespace multitetra
