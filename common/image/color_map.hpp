// Perceptually uniform maps from values to colors, and the range of values they cover.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/image/srgb.hpp"

namespace multitetra {

enum class ColorMap {
  kGray,     // Black to white.
  kViridis,  // Blue, green, yellow; lightness increases uniformly.
  // Blue to yellow; looks the same with red-green color blindness.
  kCividis,
  kCoolwarm,  // Blue, grey, red: for values around a center.
};

[[nodiscard]] std::string_view name(ColorMap map);
[[nodiscard]] std::optional<ColorMap> color_map_from(std::string_view name);

// Returns the color at `part` (0 to 1) of the map, clamped to its ends.
[[nodiscard]] Rgb color_at(ColorMap map, double part);

// Maps a range of values to colors.
struct ColorScale {
  ColorMap map = ColorMap::kGray;
  // Gets the map's first color.
  double low = 0;
  // Gets the map's last color, as do all values above `low` if high <= low.
  double high = 1;
  // Requires 0 < low < high; values <= 0 get the first color.
  bool is_logarithmic = false;
  Rgb no_value = {128, 128, 128};  // The color of NaN.

  [[nodiscard]] Rgb operator()(double value) const;
};

// Parses the name of a scale, "linear" or "log".
[[nodiscard]] std::optional<bool> is_logarithmic_from(std::string_view name);

[[nodiscard]] std::vector<Rgb> colors_of(std::span<const float> values, const ColorScale& scale);

}  // namespace multitetra
