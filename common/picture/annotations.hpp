// The scale bar and the color legend of a picture, as in the browser viewer.
#pragma once

#include <string>

#include "common/image/color_map.hpp"
#include "common/image/picture.hpp"
#include "common/picture/camera.hpp"
#include "common/picture/shading.hpp"

namespace multitetra {

struct ScaleLength {
  double world = 0;   // 1, 2 or 5 times a power of ten, in world units.
  double pixels = 0;  // At the depth of the scene's center.
};

// Returns the longest such length of at most about 110 pixels, for pictures of 720 rows.
[[nodiscard]] ScaleLength scale_length(const Camera& camera);

// Draws a bar with end strokes at the lower right, its length above. `unit`: the unit of world
// coordinates; empty: unknown.
void draw_scale_bar(Picture& picture, const Camera& camera, const std::string& unit,
                    Background background);

struct Legend {
  ColorScale scale;
  std::string name;  // The name of the values.
  std::string unit;  // Empty: unknown.
};

// Draws the color scale at the lower left, with its end values and the name above.
void draw_legend(Picture& picture, const Legend& legend, Background background);

}  // namespace multitetra
