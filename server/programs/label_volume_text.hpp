// Formats the volume of a label, for people and programs.
#pragma once

#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/json/json_report.hpp"
#include "server/dataset/dataset_metadata.hpp"

namespace multitetra {

// Returns for example "1 234 voxels (617 mm³), of which the surface holds 99.3 %".
[[nodiscard]] std::string human_label_volume(const LabelVolume& volume, const DatasetInfo& info);

[[nodiscard]] Json json_of(const LabelVolume& volume);

}  // namespace multitetra
