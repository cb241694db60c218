// The placement of N5 arrays by the attributes of the programs that write them.
#pragma once

#include <string>

#include "server/volume/formats/arrays/conventions.hpp"
#include "server/volume/formats/zarr/detail/zarr_container.hpp"

namespace multitetra {

// Reads `transform` (axes, scale, translate, units) of CellMap, `pixelResolution` and
// `downsamplingFactors` of N5 Viewer, `resolution`, `offset` and `units` of Paintera and
// Neuroglancer; of the array, or of its group. Requires that the array is N5.
void place_n5(const ZarrContainer& file, const std::string& array, ArrayMeaning& meaning);

}  // namespace multitetra
