// Images of one slice each that make up a volume, found by folder or pattern.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Whether a file name is a pattern: it has '*', '?' or a printf conversion such as %d or %03d.
[[nodiscard]] bool is_stack_pattern(std::string_view file_name);

// Orders runs of digits by their value, everything else by bytes: slice2 before slice10.
[[nodiscard]] bool natural_order_less(std::string_view a, std::string_view b);

// The TIFF files (.tif, .tiff) of the folder `path`, or those that match the pattern in the last
// part of `path`, in natural order; where there are none, the PNG files, else the JPEG files (.jpg,
// .jpeg). Empty when there are no images or the folder is missing. Hidden files are left out.
[[nodiscard]] std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path);

// The volume whose slices are the files that stack_files finds, or one image alone. They are opened
// when they are read. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_image_stack(const std::filesystem::path& path);

}  // namespace multitetra
