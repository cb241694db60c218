// Requests as keys of caches.
#pragma once

#include <string>

#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Bytes that are equal exactly for equal requests, within one process. Where a threshold grid says
// nothing (NaN) all such places are the same.
[[nodiscard]] std::string key_of(const IsosurfaceRequest& request);

}  // namespace multitetra
