// The contour level that the authors of a map recommend, from the EMDB header beside the map.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace multitetra {

// From the entry's header (emd-1234.xml of any version of the EMDB's schema) or its description of
// the web API (emd-1234.json), in the folder of the map or in ../header, where the archive of the
// EMDB has it. The names have the number of the map's name, or are the map's with another suffix.
// The primary level where there are several. nullopt when no such file says a finite number.
[[nodiscard]] std::optional<double> contour_level_beside(const std::filesystem::path& map);

// Reads such a file by its content.
[[nodiscard]] std::optional<double> contour_level_in_xml(std::string_view text);
[[nodiscard]] std::optional<double> contour_level_in_json(std::string_view text);

}  // namespace multitetra
