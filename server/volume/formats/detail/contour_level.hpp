// The contour level that the authors of a map recommend, from its EMDB header.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace multitetra {

// Reads the entry's header (emd-1234.xml, any version of the EMDB schema) or its description from
// the web API (emd-1234.json), in the folder of the map or in ../header, as in the EMDB archive.
// The file has the entry number of the map's name, or the map's name with a different suffix.
// Prefers the primary level. Returns nullopt if no such file has a finite number.
[[nodiscard]] std::optional<double> sidecar_contour_level(const std::filesystem::path& map);

// Read the text of such a file.
[[nodiscard]] std::optional<double> contour_level_in_xml(std::string_view text);
[[nodiscard]] std::optional<double> contour_level_in_json(std::string_view text);

}  // namespace multitetra
