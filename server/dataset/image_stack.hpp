// The images that make up a stack, found by directory or pattern. No image is opened here.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace multitetra {

// Whether a file name is a pattern: it has '*', '?' or a printf conversion such as %d or %03d.
[[nodiscard]] bool is_stack_pattern(std::string_view file_name);

// Orders runs of digits by their value, everything else by bytes: slice2 before slice10.
[[nodiscard]] bool naturally_less(std::string_view a, std::string_view b);

// The .tif and .tiff files of the directory `path`, or those files that match the pattern in the
// last part of `path`, in natural order. Empty when there are none or the directory is missing.
// Hidden files are left out.
[[nodiscard]] std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path);

}  // namespace multitetra
