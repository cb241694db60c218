// Lines and words in a picture: strokes with smooth edges, and letters that are made of strokes, at
// any size. There is no font to install and none to differ between machines.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "common/image/color_map.hpp"
#include "common/image/picture.hpp"

namespace multitetra {

// From one place to another, in pixels from the picture's left and upper edge; a dot where they are
// the same.
struct Stroke {
  std::array<double, 2> from = {0, 0};
  std::array<double, 2> to = {0, 0};
};

// Draws all strokes as one shape, `width` pixels wide, with round ends. What lies beside the
// picture is left out.
void draw_strokes(Picture& picture, std::span<const Stroke> strokes, double width, Rgb color);

// How far a line of text reaches, in pixels. `height`: that of a capital letter.
[[nodiscard]] double text_width(std::string_view utf8, double height);

// A line of text: `left` and `baseline` in pixels, around it a rim of another color, so that it can
// be read over anything. Characters other than ASCII, "µ", "μ", "°", "²" and "³" are written as
// "?".
void draw_text(Picture& picture, std::string_view utf8, double left, double baseline, double height,
               Rgb ink, Rgb rim);

}  // namespace multitetra
