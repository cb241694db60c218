// A dataset at a glance: how often its values occur, and below, on the same axis, how many
// triangles the surface of each value has.
#pragma once

#include <string>

#include "common/request/dataset_info.hpp"
#include "server/programs/plot/size_curves.hpp"

namespace multitetra {

// An SVG file on a light ground, 960 x 720. Both ordinates are logarithmic; the suggested isovalues
// are marked. Curves may be missing, as for data with one value only.
[[nodiscard]] std::string dataset_plot(const DatasetInfo& info, const SizeCurves& curves);

}  // namespace multitetra
