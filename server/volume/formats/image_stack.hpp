// Stacks of images, one per slice, found by folder or pattern.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file name is a pattern: with '*', '?' or a conversion such as %d or %03d.
[[nodiscard]] bool is_stack_pattern(std::string_view file_name);

// Returns the files of the folder `path`, or those that match the pattern in its last component, in
// natural order. Skips hidden files and folders. Returns none if the folder is missing.
[[nodiscard]] std::vector<std::filesystem::path> matching_files(const std::filesystem::path& path);

// Returns the TIFF files (.tif, .tiff) of matching_files(); else PNG files, else JPEG files (.jpg,
// .jpeg). Returns none if there are no images.
[[nodiscard]] std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path);

// Opens the files of stack_files() as slices, or a single image. Files are opened when they are
// read. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_image_stack(const std::filesystem::path& path);

}  // namespace multitetra
