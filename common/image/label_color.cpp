#include "common/image/label_color.hpp"

#include <cmath>
#include <numbers>

namespace multitetra {
namespace {

// Converts from the polar form of OKLab (Ottosson 2020): lightness 0 to 1, chroma, hue in radians.
Rgb rgb_from_oklch(double lightness, double chroma, double hue) {
  const double a = chroma * std::cos(hue);
  const double b = chroma * std::sin(hue);
  const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(lightness - 0.0894841775 * a - 1.291485548 * b, 3);
  return {srgb_from(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          srgb_from(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          srgb_from(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s)};
}

}  // namespace

Rgb label_color(double value) {
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  const double number = std::abs(std::round(value));
  const bool is_even = std::fmod(number, 2) == 0;
  return rgb_from_oklch(is_even ? 0.66 : 0.78, 0.11,
                        40 * std::numbers::pi / 180 + golden_angle * number);
}

}  // namespace multitetra
