// What is written on a picture: the scale bar and the legend of colors, as on the pictures of the
// browser viewer.
#pragma once

#include <string>

#include "client/picture/camera.hpp"
#include "client/picture/shading.hpp"
#include "common/image/color_map.hpp"
#include "common/image/picture.hpp"

namespace multitetra {

struct ScaleLength {
  double world = 0;   // 1, 2 or 5 times a power of ten, in world units.
  double pixels = 0;  // Its length where the middle of what is looked at lies.
};

// A length of about 110 pixels of a picture of 720 rows, and never longer.
[[nodiscard]] ScaleLength scale_length(const Camera& camera);

// Below, on the right: a line with a stroke across each of its ends, and its length above. `unit`:
// that of world coordinates; empty: unknown.
void draw_scale_bar(Picture& picture, const Camera& camera, const std::string& unit,
                    Background background);

struct Legend {
  ColorScale scale;
  std::string name;  // Of the values.
  std::string unit;  // Empty: unknown.
};

// Below, on the left: the colors from the first to the last, with their values and the name above.
void draw_legend(Picture& picture, const Legend& legend, Background background);

}  // namespace multitetra
