// `extract` of a folder: the surfaces of all its datasets, such as the labels of a segmentation.
#pragma once

#include <string>

#include "common/cli/surface_options.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

struct ExtractSeriesArguments {
  std::string folder;
  std::string output;
  MeshFormat format = MeshFormat::kPly;
  std::string report = {};  // A file; empty: none.
  bool json = false;
  bool quiet = false;
};

// Writes one GLB with a node for each dataset if they are of one time; otherwise a file for each
// dataset, with the dataset's name in its own, but none without any triangle. Returns the exit
// code. Throws ExitError (kUsage) if the datasets have different grids or the request has options
// for one dataset, (kEmptySurface) if all surfaces are empty.
[[nodiscard]] int extract_series(const ExtractSeriesArguments& arguments,
                                 const SurfaceArguments& surface);

}  // namespace multitetra
