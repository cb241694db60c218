#include "server/programs/label_volume_text.hpp"

#include <cmath>

#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"

namespace multitetra {

std::string human_label_volume(const LabelVolume& volume, const DatasetInfo& info) {
  const auto samples = static_cast<double>(volume.samples);
  const double of_one = info.spacing[0] * info.spacing[1] * info.spacing[2];
  const double percent = std::round(1000 * volume.surface_samples / samples) / 10;
  const std::string& unit = info.meaning.length_unit;
  return human_count_of(volume.samples, "voxel") +
         (unit.empty() ? "" : " (" + human_number(of_one * samples) + " " + unit + "³)") +
         ", of which the surface encloses " + human_number(percent) + " %";
}

Json json_of(const LabelVolume& volume) {
  return {{"samples", volume.samples}, {"surface_samples", volume.surface_samples}};
}

}  // namespace multitetra
