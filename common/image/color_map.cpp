#include "common/image/color_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "common/base/enum_names.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<ColorMap, 4> kNames = {{"gray", "viridis", "cividis", "coolwarm"}};

// Equally spaced colors of each map; linear in between.
constexpr std::array<Rgb, 2> kGrayColors = {{{0, 0, 0}, {255, 255, 255}}};
// S. van der Walt and N. Smith.
constexpr std::array<Rgb, 10> kViridisColors = {{{68, 1, 84},
                                                 {72, 40, 120},
                                                 {62, 73, 137},
                                                 {49, 104, 142},
                                                 {38, 130, 142},
                                                 {31, 158, 137},
                                                 {53, 183, 121},
                                                 {110, 206, 88},
                                                 {181, 222, 43},
                                                 {253, 231, 37}}};
// J. Nuñez, C. Anderton, R. Renslow.
constexpr std::array<Rgb, 12> kCividisColors = {{{0, 32, 77},
                                                 {0, 48, 111},
                                                 {42, 64, 108},
                                                 {72, 82, 107},
                                                 {94, 98, 110},
                                                 {114, 115, 116},
                                                 {135, 132, 121},
                                                 {158, 150, 119},
                                                 {182, 169, 113},
                                                 {208, 190, 103},
                                                 {234, 211, 87},
                                                 {255, 234, 70}}};
// K. Moreland.
constexpr std::array<Rgb, 9> kCoolwarmColors = {{{59, 76, 192},
                                                 {98, 130, 234},
                                                 {141, 176, 254},
                                                 {184, 208, 249},
                                                 {221, 221, 221},
                                                 {245, 196, 173},
                                                 {244, 154, 123},
                                                 {222, 96, 77},
                                                 {180, 4, 38}}};

std::span<const Rgb> colors_of(ColorMap map) {
  switch (map) {
    case ColorMap::kViridis:
      return kViridisColors;
    case ColorMap::kCividis:
      return kCividisColors;
    case ColorMap::kCoolwarm:
      return kCoolwarmColors;
    case ColorMap::kGray:
      break;
  }
  return kGrayColors;
}

}  // namespace

std::string_view name(ColorMap map) { return kNames.of(map); }

std::optional<ColorMap> color_map_from(std::string_view name) { return kNames.find(name); }

Rgb color_at(ColorMap map, double part) {
  const std::span<const Rgb> colors = colors_of(map);
  const auto last = static_cast<double>(colors.size() - 1);
  const double at = std::isnan(part) ? 0 : std::clamp(part, 0.0, 1.0) * last;
  const auto below = static_cast<std::size_t>(std::min(at, last - 1));
  const double beyond = at - static_cast<double>(below);
  Rgb color{};
  for (std::size_t channel = 0; channel < color.size(); ++channel) {
    const double mixed =
        (1 - beyond) * colors[below][channel] + beyond * colors[below + 1][channel];
    color[channel] = static_cast<std::uint8_t>(std::lround(mixed));
  }
  return color;
}

Rgb ColorScale::operator()(double value) const {
  if (std::isnan(value)) return no_value;
  if (!(high > low)) return color_at(map, value > low ? 1 : 0);
  if (!is_logarithmic) return color_at(map, (value - low) / (high - low));
  if (!(value > 0)) return color_at(map, 0);
  return color_at(map, std::log(value / low) / std::log(high / low));
}

std::optional<bool> is_logarithmic_from(std::string_view name) {
  if (name == "linear") return false;
  if (name == "log") return true;
  return std::nullopt;
}

std::vector<Rgb> colors_of(std::span<const float> values, const ColorScale& scale) {
  std::vector<Rgb> colors;
  colors.reserve(values.size());
  for (const float value : values) colors.push_back(scale(static_cast<double>(value)));
  return colors;
}

}  // namespace multitetra
