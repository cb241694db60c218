// The files that the reader of a source needs.
#pragma once

#include <filesystem>
#include <vector>

namespace multitetra {

// Returns the folder of the source, or the source if it is a folder with the XML file of its name
// beside, and where symbolic links in it lead; everything if the source may name files elsewhere.
// For a source at an address: nothing.
[[nodiscard]] std::vector<std::filesystem::path> readable_files(const std::filesystem::path& source,
                                                                bool allow_external_files);

}  // namespace multitetra
