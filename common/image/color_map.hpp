// Maps from values to colors, in which equal steps of the value look like equal steps, and the
// range of values that they cover.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace multitetra {

using Rgb = std::array<std::uint8_t, 3>;  // Red, green, blue in sRGB.

enum class ColorMap {
  kGray,     // Black to white.
  kViridis,  // Blue, green, yellow; lightness grows evenly.
  // Blue to yellow, equal for people with red-green color blindness.
  kCividis,
  kCoolwarm,  // Blue, grey, red: for values around a middle.
};

// Every map, in words: "gray, viridis, cividis or coolwarm".
inline constexpr std::string_view kColorMapNames = "gray, viridis, cividis or coolwarm";
[[nodiscard]] std::string_view name(ColorMap map);
[[nodiscard]] std::optional<ColorMap> color_map_from(std::string_view name);

// The color at `part` of the way, 0 to 1; what is beyond has the color of the end.
[[nodiscard]] Rgb color_at(ColorMap map, double part);

// The colors of a range of values.
struct ColorScale {
  ColorMap map = ColorMap::kGray;
  double low = 0;   // Has the map's first color.
  double high = 1;  // Has its last one; where it is not above `low`, values above low have it.
  bool is_logarithmic =
      false;  // Requires 0 < low < high; what is not positive has the first color.
  Rgb no_value = {128, 128, 128};  // The color of NaN.

  [[nodiscard]] Rgb operator()(double value) const;
};

// Whether a scale of that name, "linear" or "log", is logarithmic.
[[nodiscard]] std::optional<bool> is_logarithmic_from(std::string_view name);

// "ff8000": red, green and blue in hexadecimal digits of either case; nullopt for anything else.
[[nodiscard]] std::optional<Rgb> rgb_from(std::string_view text);

[[nodiscard]] std::vector<Rgb> colors_of(std::span<const float> values, const ColorScale& scale);

}  // namespace multitetra
