// Requests as keys of caches.
#pragma once

#include <string>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Bytes that are equal exactly for equal requests, within one process. Where a threshold grid says
// nothing (NaN) all such places are the same.
[[nodiscard]] std::string key_of(const IsosurfaceRequest& request);

// The same for datasets whose answers are equal: also of one that was replaced under its name.
[[nodiscard]] std::string key_of(const DatasetInfo& info);

}  // namespace multitetra
