// NRRD, with samples after the header or in data files (.nhdr).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are raw, gzip, bzip2, text or hex; raw and compressed ones may be in several files. World
// coordinates are LPS if `space` names patient axes (RAS and LAS are converted), by default in mm;
// else those of the file. The unit is that of `space units`, or of `units` beside plain `spacings`,
// where `space` defines no directions and is ignored. A non-spatial axis contains components or
// times: according to its kind (choice.component selects from a list), else by its missing
// direction, else it is the last of four. Times come from 3D Slicer's keys ("axis 0 index values"),
// or from the axis's spacing, minimum and unit. Labels are 3D Slicer's segments. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_nrrd(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
