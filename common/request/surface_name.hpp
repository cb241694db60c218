// What a surface is called in files.
#pragma once

#include <optional>
#include <string>

#include "common/request/dataset_info.hpp"

namespace multitetra {

struct SurfaceName {
  std::string text = {};                       // Empty: none.
  std::optional<double> label = std::nullopt;  // The number of its label in the label map.
};

// Returns the label's name for a label that has one, else the dataset's.
[[nodiscard]] SurfaceName surface_name(const DatasetInfo& info);

}  // namespace multitetra
