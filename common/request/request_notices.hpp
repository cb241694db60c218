// Warnings about valid but probably unintended requests: an isovalue without a surface, an error
// for places outside the data. One sentence each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Checks in advance whether the isovalue is outside the dataset's values, and whether a region or
// the threshold grid lies completely outside its samples (by more than one sample). Misses some
// such regions if the data's axes are oblique, but never reports others. Of a served request also
// reports that its budget more than doubled the error. Requires a valid request.
[[nodiscard]] std::vector<std::string> request_notices(const IsosurfaceRequest& request,
                                                       const DatasetInfo& info);

// Explains why a surface has no triangles.
[[nodiscard]] std::string empty_surface_text(const IsosurfaceRequest& request,
                                             const DatasetInfo& info);

// Returns "removal fills 12 cavities, whose walls are components: 345 cubic world units".
[[nodiscard]] std::string filled_text(const FilledCavities& filled);

// Returns the notice that the dataset `field`, which colors a surface, has no value at some of its
// vertices; empty if it has all. Values are NaN where there is none.
[[nodiscard]] std::vector<std::string> missing_values_notice(std::span<const float> values,
                                                             const std::string& field);

// Returns the notice that the file was not written because the surface is empty.
[[nodiscard]] std::string not_written_text(const std::string& file);

// Returns the same for several surfaces, such as some of the times of a series.
[[nodiscard]] std::string not_written_text(std::span<const std::string> names);

}  // namespace multitetra
