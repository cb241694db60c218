#include "server/programs/label_volume_text.hpp"

#include <cmath>

#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"

namespace multitetra {

namespace {

// Returns whether the label reaches the end of the map, where its surface closes in the margin.
bool meets_end(const DatasetInfo& info) {
  if (!info.label_extent || !info.label_extent->place) return false;
  const LabelExtent::Place& place = *info.label_extent->place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (place.least[axis] == 0 || place.greatest[axis] == info.dims[axis] - 1) return true;
  }
  return false;
}

}  // namespace

std::string human_label_volume(const LabelVolume& volume, const DatasetInfo& info) {
  const auto samples = static_cast<double>(volume.samples);
  const double of_one = info.spacing[0] * info.spacing[1] * info.spacing[2];
  const double percent = std::round(1000 * volume.surface_samples / samples) / 10;
  const std::string& unit = info.meaning.length_unit;
  return human_count_of(volume.samples, "voxel") +
         (unit.empty() ? "" : " (" + human_number(of_one * samples) + " " + unit + "³)") +
         ", of which the surface encloses " + human_number(percent) + " %" +
         (meets_end(info) ? " inside the image and less at its end, where it closes" : "");
}

Json json_of(const LabelVolume& volume) {
  return {{"samples", volume.samples}, {"surface_samples", volume.surface_samples}};
}

}  // namespace multitetra
