// The isosurfaces of several datasets of one grid, such as the labels of a segmentation, simplified
// together: where two of them touch they still have the same triangles afterwards.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "common/request/isosurface_request.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

struct TouchingSurfaces {
  // One for each dataset.
  std::vector<Simplified> surfaces;
  // For each dataset, the number of triangles that its surface has in common with others.
  std::vector<std::size_t> common_triangles;
};

// Extracts the full-resolution surfaces and simplifies them as far as the request allows, on all
// threads; the result is the same for any number of them. With `request.intersection_free` patches
// are simplified one after another. Requires datasets of equal dimensions, spacings and margins and
// a request that is valid for each, without budget. Throws Cancelled soon after `stop` is
// triggered, and DatasetFileError when a dataset turns out to be damaged.
[[nodiscard]] TouchingSurfaces extract_touching(std::span<const DatasetPtr> datasets,
                                                const IsosurfaceRequest& request,
                                                const std::stop_token& stop = {});

}  // namespace multitetra
