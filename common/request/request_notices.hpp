// Warnings about valid requests that are hardly meant so: an isovalue without a surface, an error
// for places outside the data. One sentence for each.
#pragma once

#include <string>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Decided before anything is computed: the isovalue is not among the dataset's values, or a region
// or the grid of thresholds lies wholly outside its samples (more than one sample away). Not every
// such region is found where the data's axes are oblique; one that is reported is outside. Requires
// a valid request.
[[nodiscard]] std::vector<std::string> request_notices(const IsosurfaceRequest& request,
                                                       const DatasetInfo& info);

// Why a surface without a triangle is empty, for people.
[[nodiscard]] std::string empty_surface_text(const IsosurfaceRequest& request,
                                             const DatasetInfo& info);

// The notice that a file was not written for it.
[[nodiscard]] std::string not_written_text(const std::string& file);

}  // namespace multitetra
