// The text of openapi.json, the description of the HTTP interface.
#pragma once

#include <string_view>

namespace multitetra {

extern const std::string_view kOpenApi;

}  // namespace multitetra
