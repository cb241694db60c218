#include "common/image/srgb.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/parse_number.hpp"

namespace multitetra {

Rgb unpacked(std::uint32_t color) {
  return {static_cast<std::uint8_t>(color >> 16 & 0xff),
          static_cast<std::uint8_t>(color >> 8 & 0xff), static_cast<std::uint8_t>(color & 0xff)};
}

std::optional<Rgb> rgb_from(std::string_view text) {
  const auto value = parse_number<std::uint32_t>(text, 16);
  if (text.size() != 6 || !value) return std::nullopt;
  return unpacked(*value);
}

std::uint32_t packed(const Rgb& color) {
  return std::uint32_t{color[0]} << 16 | std::uint32_t{color[1]} << 8 | color[2];
}

float linear_light(int srgb) {
  const double v = srgb / 255.0;
  return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

Light linear_light(const Rgb& color) {
  return {linear_light(color[0]), linear_light(color[1]), linear_light(color[2])};
}

std::uint8_t srgb_from(double light) {
  const double v = std::clamp(light, 0.0, 1.0);
  const double coded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * coded));
}

}  // namespace multitetra
