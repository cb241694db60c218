// NRRD, with its samples behind the header or in data files (.nhdr).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Samples are raw, gzip, bzip2, text or hex; raw and packed ones may lie in several files. World
// coordinates are LPS where `space` names a patient's axes (RAS and LAS are turned), in mm or the
// unit of `space units`; else they are the file's own. `space` beside plain `spacings` defines no
// directions and is ignored. An axis outside space has the components of a sample, or the times: by
// its kind (a list that choice.component chooses from has components), else by its missing
// direction, else it is the last of four. Times are those of 3D Slicer's keys ("axis 0 index
// values"), or from spacing, least place and unit of the axis. Labels are the segments of 3D
// Slicer. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_nrrd(const std::filesystem::path& file, const VolumeChoice& choice);

}  // namespace multitetra
