// TIFF files with one or several pages.
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Pages are slices. If ImageJ, OME-XML or tifffile describes them, they are slices, channels and
// times (choice.channel and choice.time select) of one of several images (choice.series), with
// spacing and unit; else the resolution gives the spacing along x and y in mm, unless it is a
// screen's 72 or 96 pixels per inch. All images may follow the only page, as in MetaMorph stacks.
// The pages of an OME-TIFF set may be in several files, and their description in a file of its own.
// Samples are used as stored, including palette indices. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_tiff(const std::filesystem::path& file, const VolumeChoice& choice);

// Opens an image of a stack. Ignores a description that refers to other pages.
[[nodiscard]] StoredVolume open_tiff_slice(const std::filesystem::path& file);

}  // namespace multitetra
