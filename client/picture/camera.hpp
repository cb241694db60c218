// The camera of a picture.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "common/base/affine.hpp"

namespace multitetra {

// The directions from which the browser viewer looks at first: from the front (patients look along
// -y), a little from the right and from above.
inline constexpr double kDefaultAzimuth = 30;    // Degrees.
inline constexpr double kDefaultElevation = 15;  // Degrees.
inline constexpr int kMaxPictureSide = 16384;    // Pixels.

// A pinhole with square pixels. The three directions are orthonormal and right-handed: right, up,
// and back, from what is looked at to the eye.
struct Camera {
  int width = 0;  // Pixels, 1 to kMaxPictureSide.
  int height = 0;
  Vec3 eye = {0, 0, 0};
  Vec3 right = {1, 0, 0};
  Vec3 up = {0, 0, 1};
  Vec3 back = {0, -1, 0};
  double pixels_at_one = 1;  // Pixels that a length of 1 covers at distance 1.
  double distance = 1;       // From the eye to the middle of what is looked at.

  // Along right, up and back, seen from the eye: what is in front of it has a negative third one.
  [[nodiscard]] Vec3 seen(const Vec3& place) const;
};

// Looks at the middle of the places' bounding box, near enough for the places to fill the picture
// with a small margin: all of them lie in front of the eye and inside the picture. Azimuth turns
// around the z axis, 0 looks along +y and 90 along -x; elevation is from -90 (from below) to 90
// (from above). Where another axis is up, all directions are turned as in the viewer: by the
// shortest way from z to it, and around y where that is -z. Without places the camera looks at a
// ball of radius 1 around the origin.
[[nodiscard]] Camera framing(std::span<const std::array<float, 3>> places, double azimuth,
                             double elevation, int width, int height, const Vec3& up = {0, 0, 1});

// "y" or "-z"; nullopt for anything that is no axis.
[[nodiscard]] std::optional<Vec3> up_axis_from(std::string_view text);

}  // namespace multitetra
