// A volume in the process of the interpreter.
#pragma once

#include <memory>

#include "server/dataset/dataset.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

struct PythonVolume {
  explicit PythonVolume(DatasetPtr opened);

  [[nodiscard]] const DatasetInfo& info() const { return dataset->info; }

  DatasetPtr dataset;
  std::shared_ptr<const SurfaceProvider> surfaces;
};

}  // namespace multitetra
