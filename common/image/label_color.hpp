// Colors of labels that have no color in their file.
#pragma once

#include "common/image/srgb.hpp"

namespace multitetra {

// Returns the same color as the viewer: of two lightnesses in turn, and with hues a golden angle
// apart, so that consecutive labels differ clearly.
[[nodiscard]] Rgb label_color(double value);

}  // namespace multitetra
