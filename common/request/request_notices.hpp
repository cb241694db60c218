// Warnings about valid but probably unintended requests: an isovalue without a surface, an error
// for places outside the data. One sentence each.
#pragma once

#include <string>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Checks in advance whether the isovalue is outside the dataset's values, and whether a region or
// the threshold grid lies completely outside its samples (by more than one sample). Misses some
// such regions if the data's axes are oblique, but never reports others. Requires a valid request.
[[nodiscard]] std::vector<std::string> request_notices(const IsosurfaceRequest& request,
                                                       const DatasetInfo& info);

// Explains why a surface has no triangles.
[[nodiscard]] std::string empty_surface_text(const IsosurfaceRequest& request,
                                             const DatasetInfo& info);

// Returns the notice that the file was not written because the surface is empty.
[[nodiscard]] std::string not_written_text(const std::string& file);

}  // namespace multitetra
