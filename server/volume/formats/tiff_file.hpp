// TIFF files with one image or with several pages.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Pages are slices. Where ImageJ or OME-XML describes them, they are slices, channels and times,
// which choice.channel and choice.time choose from, with spacing and unit; else the resolution is
// the spacing along x and y, in mm, unless it is a screen's 72 or 96 pixels an inch. Samples are
// taken as they are stored: of images with a palette their indices. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_tiff(const std::filesystem::path& file, const VolumeChoice& choice);

// The same of one image of a stack: a description that speaks of other pages than its own is
// ignored.
[[nodiscard]] StoredVolume open_tiff_slice(const std::filesystem::path& file);

}  // namespace multitetra
