// Names and windows of channels, and names of labels, in the attributes of an OME-Zarr image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

// Returns `count` channels, at most kMaxSourceMembers, with the display names of "omero".
[[nodiscard]] std::vector<SourceField> zarr_channels(const nlohmann::json& attributes,
                                                     std::int64_t count);

// Returns the window of a channel in "omero", from "start" to "end"; none if there is none. Adds a
// notice about a window that is not two finite numbers, the smaller first, and ignores it.
[[nodiscard]] std::optional<DisplayWindow> zarr_window(const nlohmann::json& attributes,
                                                       std::int64_t channel,
                                                       const std::filesystem::path& place,
                                                       std::vector<std::string>& notices);

// Returns the named labels of a label image. The key of a name depends on the writer.
[[nodiscard]] std::vector<SourceLabel> zarr_labels(const nlohmann::json& attributes);

}  // namespace multitetra
