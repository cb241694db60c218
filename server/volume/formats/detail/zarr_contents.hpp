// Names of channels and labels in the attributes of an OME-Zarr image.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

// Returns `count` channels, at most kMaxSourceMembers, with the display names of "omero".
[[nodiscard]] std::vector<SourceField> zarr_channels(const nlohmann::json& attributes,
                                                     std::int64_t count);

// Returns the named labels of a label image. The key of a name depends on the writer.
[[nodiscard]] std::vector<SourceLabel> zarr_labels(const nlohmann::json& attributes);

}  // namespace multitetra
