// How a surface and what is behind it look: colours, and the light that comes from the eye.
#pragma once

#include <array>
#include <cstdint>

#include "client/picture/picture.hpp"
#include "common/base/affine.hpp"

namespace multitetra {

// Red, green and blue, proportional to light: they may be averaged. 0 to 1.
using Light = std::array<float, 3>;

enum class Background { kDark, kLight, kTransparent };

// The colour of a surface at a place. All directions have length 1 and are those of Camera::seen.
//
// normal        Out of the side of low values.
// to_eye        From the place to the eye.
// upwards       The world's z axis: what faces it is a little brighter.
//
// Where the eye looks at the inside, which it sees where the surface ends, the colour is darker and
// redder, as in the browser viewer.
[[nodiscard]] Light lit(const Vec3& normal, const Vec3& to_eye, const Vec3& upwards,
                        bool is_inside);

// What is seen beside the surface: brighter in the middle. `x` and `y` are from -1 to 1.
[[nodiscard]] Light background_at(Background background, double x, double y);

// Back to the numbers of an image.
[[nodiscard]] std::uint8_t srgb(float light);

}  // namespace multitetra
