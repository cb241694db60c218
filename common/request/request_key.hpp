// Requests as keys of caches.
#pragma once

#include <string>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Bytes that are equal exactly for equal requests, within one process. All places of a threshold
// grid without a threshold (NaN) are equal.
[[nodiscard]] std::string key_of(const IsosurfaceRequest& request);

// The same for datasets whose answers are equal: also of one that was replaced under its name.
[[nodiscard]] std::string key_of(const DatasetInfo& info);

}  // namespace multitetra
