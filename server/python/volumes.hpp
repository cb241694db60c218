// A volume in the process of the interpreter.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "server/dataset/dataset.hpp"
#include "server/dataset/prepare.hpp"
#include "server/python/interruptible.hpp"
#include "server/python/sources.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// The border of the data and the limits of a call.
struct PythonCall {
  std::optional<double> pad_value;
  std::int32_t pad = 0;
  int threads = 0;
  pybind11::object progress;
};

// Returns the options of preparing a source, which stops with Cancelled when `state` asks for it.
[[nodiscard]] PrepareOptions options_for(const PythonSource& source, const PythonCall& call,
                                         OperationState& state);

struct PythonVolume {
  explicit PythonVolume(DatasetPtr opened);

  [[nodiscard]] const DatasetInfo& info() const { return dataset->info; }

  DatasetPtr dataset;
  std::shared_ptr<const SurfaceProvider> surfaces;
};

}  // namespace multitetra
