#include "common/picture/shading.hpp"

#include <algorithm>
#include <cmath>

namespace multitetra {
namespace {

Light mixed(const Light& a, const Light& b, double share) {
  const auto t = static_cast<float>(share);
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

}  // namespace

Light shaded(const Vec3& normal, const Vec3& to_eye, const Vec3& upwards, bool is_inside,
             const std::optional<Light>& own_color) {
  static const Light kOutside = linear_light(Rgb{0xe0, 0xcd, 0xb4});
  static const Light kInside = linear_light(Rgb{0x8f, 0x6c, 0x5c});
  // A lamp above the left shoulder of the viewer shows more of the shape than one at the eye.
  const Vec3 lamp = normalized({to_eye[0] - 0.45, to_eye[1] + 0.55, to_eye[2]});
  const double facing = std::max(0.0, dot(normal, lamp));
  const double from_above = 0.5 + 0.5 * dot(normal, upwards);
  const Vec3 half = normalized({lamp[0] + to_eye[0], lamp[1] + to_eye[1], lamp[2] + to_eye[2]});
  double shine = std::max(0.0, dot(normal, half));
  for (int doubling = 0; doubling < 5; ++doubling) shine *= shine;  // Raises to the power of 32.
  constexpr float kDarkerInside = 0.5F;
  Light color = is_inside ? kInside : kOutside;
  if (own_color) {
    const float part = is_inside ? kDarkerInside : 1;
    color = {part * (*own_color)[0], part * (*own_color)[1], part * (*own_color)[2]};
  }
  const double light = 0.08 + 0.10 * from_above + 0.86 * facing;
  Light result;
  for (std::size_t i = 0; i < 3; ++i) {
    result[i] = std::min(1.0F, static_cast<float>(light * color[i] + 0.05 * shine));
  }
  return result;
}

Light background_at(Background background, double x, double y) {
  static const Light kGlow = linear_light(Rgb{0x26, 0x2c, 0x35});
  static const Light kDark = linear_light(Rgb{0x14, 0x17, 0x1c});
  static const Light kWhite = linear_light(Rgb{0xff, 0xff, 0xff});
  static const Light kLight = linear_light(Rgb{0xe9, 0xed, 0xf1});
  if (background == Background::kTransparent) return {0, 0, 0};
  const double from_middle = std::min(1.0, std::sqrt(x * x + y * y) / 1.2);
  return background == Background::kDark ? mixed(kGlow, kDark, from_middle)
                                         : mixed(kWhite, kLight, from_middle);
}

}  // namespace multitetra
