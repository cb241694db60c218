// The JSON of Zarr and N5 metadata.
#pragma once

#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace multitetra {

// Parses untrusted text; is_discarded() if it is not JSON. Python also writes NaN, Infinity and
// -Infinity, which JSON does not have; they become the strings that Zarr uses for fill values.
[[nodiscard]] nlohmann::json parse_zarr_json(std::string_view text);

}  // namespace multitetra
