// NRRD, with its samples behind the header or in data files (.nhdr).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are raw, gzip, bzip2, text or hex; of raw and packed ones there may be several files.
// World coordinates are LPS where `space` names a patient's axes (RAS and LAS are turned), in mm or
// the unit that `space units` names; else they are the file's own. `space` beside plain `spacings`
// says nothing about directions and is left out. An axis that is none of space has the components
// of a sample, or the times: by its kind (a list that choice.component chooses from has
// components), else by its missing direction, else it is the last of four. Times are those of 3D
// Slicer's keys ("axis 0 index values"), or what spacing, least place and unit of the axis say.
// Labels are the segments that 3D Slicer names. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_nrrd(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
