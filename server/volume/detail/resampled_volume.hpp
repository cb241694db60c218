// A volume whose slices are resampled to a rectangular grid.
#pragma once

#include <memory>

#include "server/volume/formats/slice_places.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

enum class Resampling {
  kLinear,   // Floats; void (NaN) where no slice reaches.
  kNearest,  // The values and the type of the nearest samples; 0 where no slice reaches.
};

// Returns `slices` on the grid of `places`, of which places.at has each slice's. The header of
// `slices` has the placement of that grid already.
[[nodiscard]] std::unique_ptr<VolumeSource> resampled_volume(std::unique_ptr<VolumeSource> slices,
                                                             SlicePlaces places,
                                                             Resampling resampling);

}  // namespace multitetra
