// Cache keys for requests.
#pragma once

#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Returns bytes that are equal if and only if the requests are, within one process. All NaNs of a
// threshold grid are equal.
[[nodiscard]] std::string key_of(const IsosurfaceRequest& request);

// Returns a key for datasets that give equal replies; it changes if a dataset is replaced.
[[nodiscard]] std::string key_of(const DatasetInfo& info);

}  // namespace multitetra
