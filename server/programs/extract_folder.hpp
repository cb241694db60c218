// `extract` of a folder: the surfaces of all its datasets, such as the labels of a segmentation.
#pragma once

#include "server/programs/local_output.hpp"

namespace multitetra {

// Writes one GLB with a node for each dataset if they are of one time; otherwise a file for each
// dataset, with the dataset's name in its own, but none without any triangle. Returns the exit
// code. Throws ExitError (kUsage) if the datasets have different grids or the request has options
// for one dataset, (kEmptySurface) if all surfaces are empty.
[[nodiscard]] int extract_folder(const LocalArguments& arguments);

}  // namespace multitetra
