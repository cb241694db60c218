// The camera of a picture.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "common/base/affine.hpp"

namespace multitetra {

// The initial view of the browser viewer: from the front (patients look along -y), slightly from
// the right and from above.
inline constexpr double kDefaultAzimuth = 30;    // Degrees.
inline constexpr double kDefaultElevation = 15;  // Degrees.
inline constexpr int kMaxPictureSide = 16384;    // Pixels.

// A pinhole camera with square pixels. Right, up and back (from the scene's center to the eye) are
// orthonormal and right-handed.
struct Camera {
  int width = 0;  // Pixels, 1 to kMaxPictureSide.
  int height = 0;
  Vec3 eye = {0, 0, 0};
  Vec3 right = {1, 0, 0};
  Vec3 up = {0, 0, 1};
  Vec3 back = {0, -1, 0};
  double pixels_at_one = 1;  // The pixels covered by a length of 1 at distance 1.
  double distance = 1;       // From the eye to the scene's center.

  // Returns coordinates along right, up and back relative to the eye; the third is negative in
  // front.
  [[nodiscard]] Vec3 seen(const Vec3& place) const;
};

// Looks at the center of the points' bounding box, from the distance at which they fill the picture
// with a small margin: all lie in front of the eye and inside the picture. Azimuth turns around the
// z axis: 0 looks along +y and 90 along -x; elevation is from -90 (from below) to 90 (from above).
// For another up axis all directions are rotated as in the viewer: by the shortest rotation from z
// to it, and around y for -z. Without points the camera looks at the unit ball around the origin.
[[nodiscard]] Camera framing(std::span<const Vec3> points, double azimuth, double elevation,
                             int width, int height, const Vec3& up = {0, 0, 1});

// Parses "y" or "-z"; nullopt for anything that is not an axis.
[[nodiscard]] std::optional<Vec3> up_axis_from(std::string_view text);

}  // namespace multitetra
