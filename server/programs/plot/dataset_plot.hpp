// Draws an overview of a dataset: the histogram of its values, and on the same axis the number of
// triangles of the surface at each value.
#pragma once

#include "common/dataset/dataset_info.hpp"
#include "common/picture/canvas.hpp"
#include "server/programs/plot/size_curves.hpp"

namespace multitetra {

inline constexpr int kPlotWidth = 960;
inline constexpr int kPlotHeight = 720;

// Draws on white. Both ordinates are logarithmic; the suggested isovalues are marked. `curves` may
// be empty, as for data with a single value.
void draw_dataset_plot(Canvas& canvas, const DatasetInfo& info, const SizeCurves& curves);

}  // namespace multitetra
