// The description of all of this, openapi.json, as it is served.
#pragma once

#include <string_view>

namespace multitetra {

extern const std::string_view kOpenApi;

}  // namespace multitetra
