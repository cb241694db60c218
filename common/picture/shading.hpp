// Colors of a surface, lit from near the eye, and of the background.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/base/vec3.hpp"
#include "common/image/picture.hpp"
#include "common/image/srgb.hpp"

namespace multitetra {

enum class Background { kDark, kLight, kTransparent };

// Returns `v` scaled to length 1; the zero vector becomes the direction to the eye.
[[nodiscard]] inline Vec3 normalized(const Vec3& v) {
  const double size = length(v);
  return size > 0 ? scaled(v, 1 / size) : Vec3{0, 0, 1};
}

// Returns the color of a surface at a place. All directions have length 1 and are those of
// Camera::seen.
//
// normal        Towards low values.
// to_eye        From the place to the eye.
// upwards       The world's z axis: surfaces that face it are slightly brighter.
//
// The inside of a surface, visible where the surface ends, is darker and redder, as in the browser
// viewer; surfaces with a color of their own are only darker.
[[nodiscard]] Light shaded(const Vec3& normal, const Vec3& to_eye, const Vec3& upwards,
                           bool is_inside, const std::optional<Light>& own_color = {});

// Returns the background, which is brighter in the middle. `x` and `y` are from -1 to 1.
[[nodiscard]] Light background_at(Background background, double x, double y);

}  // namespace multitetra
