// Colors as displays take them (sRGB, IEC 61966-2-1) and as light that may be added and averaged.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace multitetra {

using Rgb = std::array<std::uint8_t, 3>;  // Red, green, blue in sRGB.
using Light = std::array<float, 3>;       // Linear red, green and blue, 0 to 1.

// Converts 0xRRGGBB; ignores higher bits.
[[nodiscard]] Rgb unpacked(std::uint32_t color);

// Parses red, green and blue as hexadecimal digits of either case, "ff8000".
[[nodiscard]] std::optional<Rgb> rgb_from(std::string_view text);

// Converts to 0xRRGGBB.
[[nodiscard]] std::uint32_t packed(const Rgb& color);

// Converts an sRGB value, 0 to 255, to linear light.
[[nodiscard]] float linear_light(int srgb);
[[nodiscard]] Light linear_light(const Rgb& color);

// Converts linear light, clamped to 0 to 1, to the nearest sRGB value.
[[nodiscard]] std::uint8_t srgb_from(double light);

}  // namespace multitetra
