// Draws antialiased lines and text of any size. Letters consist of strokes: no font needs to be
// installed, so pictures are identical on all machines.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "common/image/picture.hpp"
#include "common/image/srgb.hpp"

namespace multitetra {

// A segment between two places, in pixels from the upper left corner; a dot if they are equal.
struct Stroke {
  std::array<double, 2> from = {0, 0};
  std::array<double, 2> to = {0, 0};
};

// Draws all strokes as one shape, `width` pixels wide, with round ends, clipped to the picture.
void draw_strokes(Picture& picture, std::span<const Stroke> strokes, double width, Rgb color);

// Returns the width of a line of text in pixels. `height`: the height of a capital letter.
[[nodiscard]] double text_width(std::string_view utf8, double height);

// Draws a line of text at `left` and `baseline`, in pixels, with a rim of another color to be
// legible anywhere. Replaces characters other than ASCII, "µ", "μ", "°", "²" and "³" by "?".
void draw_text(Picture& picture, std::string_view utf8, double left, double baseline, double height,
               Rgb ink, Rgb rim);

}  // namespace multitetra
