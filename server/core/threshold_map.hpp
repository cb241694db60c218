// What a request allows where: the largest error that is accepted at every place. Coordinates in
// grid steps, thresholds in world units.
#pragma once

#include <cassert>

#include "common/affine.hpp"

namespace multitetra {

// A closed box of places, in grid steps.
struct Box {
  Vec3 low;
  Vec3 high;
};

class ThresholdMap {
 public:
  // The same threshold everywhere; world units, >= 0.
  [[nodiscard]] static ThresholdMap everywhere(double threshold) {
    assert(threshold >= 0);
    return ThresholdMap(threshold);
  }

  // The least threshold anywhere in `box`; never larger than the true minimum.
  [[nodiscard]] double least_in([[maybe_unused]] const Box& box) const { return threshold_; }

  // Over all places: bounds that need no look at the place.
  [[nodiscard]] double least() const { return threshold_; }
  [[nodiscard]] double largest() const { return threshold_; }

 private:
  explicit ThresholdMap(double threshold) : threshold_(threshold) {}

  double threshold_;
};

}  // namespace multitetra
