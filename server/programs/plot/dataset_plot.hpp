// Draws an overview of a dataset: the histogram of its values, and on the same axis the number of
// triangles of the surface at each value.
#pragma once

#include <string>

#include "common/dataset/dataset_info.hpp"
#include "server/programs/plot/size_curves.hpp"

namespace multitetra {

// Returns an SVG file of 960 x 720 with a light background. Both ordinates are logarithmic; the
// suggested isovalues are marked. `curves` may be empty, as for data with a single value.
[[nodiscard]] std::string dataset_plot(const DatasetInfo& info, const SizeCurves& curves);

}  // namespace multitetra
