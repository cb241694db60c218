// The name and the color of a surface in files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

struct SurfaceName {
  std::string text = {};                              // Empty: none.
  std::optional<double> label = std::nullopt;         // The number of its label in the label map.
  std::optional<std::uint32_t> color = std::nullopt;  // 0xRRGGBB in sRGB; absent: any.
};

// Returns the label's name for a label that has one, else the dataset's, with its display_color().
[[nodiscard]] SurfaceName surface_name(const DatasetInfo& info);

}  // namespace multitetra
