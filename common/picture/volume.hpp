// Samples that are drawn as a volume, together with surfaces: light from along each ray, as in the
// browser viewer, or the largest value (maximum intensity projection).
//
// Opacity and color follow the value (Levoy 1988). Between two places on a ray the opacity is the
// mean over the values between theirs (pre-integrated; Engel, Kraus and Ertl 2001), so that
// ranges of values down to a thousandth of that of the opacities are not missed.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/base/affine.hpp"
#include "common/image/color_map.hpp"

namespace multitetra {

// The opacity of a layer that is one voxel thick.
struct OpacityPoint {
  double value = 0;
  double opacity = 0;  // 0 to 1.
};

struct DrawnVolume {
  std::array<std::size_t, 3> counts = {2, 2, 2};  // Samples along each axis, at least 2.
  // In world order: the first axis changes fastest; NaN where there is no value.
  std::vector<float> values;
  // Maps indices of these samples to the surfaces' coordinates. Invertible.
  Affine to_world;
  double voxel = 1;  // The thickness that opacities apply to, in the world. Positive.
  // By ascending value, at least one; linear between them, constant beyond. At two points with one
  // value the opacity steps.
  std::vector<OpacityPoint> opacities;
  ColorScale colors;
  bool is_maximum = false;  // Shows the largest value of each ray; opacities are not used.
  bool is_lit = true;       // By the gradient, from the eye.
};

}  // namespace multitetra
