// Shading of a surface and its background: colors, with a light at the eye.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/vec3.hpp"
#include "common/image/picture.hpp"

namespace multitetra {

// Red, green and blue, proportional to light: they may be averaged. 0 to 1.
using Light = std::array<float, 3>;

enum class Background { kDark, kLight, kTransparent };

// `v` with length 1; 0 becomes the direction to the eye.
[[nodiscard]] inline Vec3 normalized(const Vec3& v) {
  const double size = length(v);
  return size > 0 ? scaled(v, 1 / size) : Vec3{0, 0, 1};
}

// The color of a surface at a place. All directions have length 1 and are those of Camera::seen.
//
// normal        Out of the side of low values.
// to_eye        From the place to the eye.
// upwards       The world's z axis: what faces it is a little brighter.
//
// Where the eye looks at the inside, which it sees where the surface ends, the color is darker and
// redder, as in the browser viewer; a surface of a color of its own is darker there.
[[nodiscard]] Light lit(const Vec3& normal, const Vec3& to_eye, const Vec3& upwards, bool is_inside,
                        const std::optional<Light>& own_color = {});

// The meaning of an image's numbers, 0 to 255.
[[nodiscard]] float light_of(int srgb);

// The background: brighter in the middle. `x` and `y` are from -1 to 1.
[[nodiscard]] Light background_at(Background background, double x, double y);

// Back to the numbers of an image.
[[nodiscard]] std::uint8_t srgb(float light);

}  // namespace multitetra
