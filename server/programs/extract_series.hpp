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

// Writes one GLB with a node for each dataset; in other formats a file for each dataset, with the
// dataset's name in its own. Returns the exit code. Throws ExitError (kUsage) when the datasets
// differ in their grids or in where they lie, or the request has a budget.
[[nodiscard]] int extract_series(const ExtractSeriesArguments& arguments,
                                 const SurfaceArguments& surface);

}  // namespace multitetra
