// The pictures of an order: one, or one for each time of a series, and how their surfaces look.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "common/picture/rasterizer.hpp"

namespace multitetra {

// The surfaces of one picture: all of an order, or those of one time.
struct Scene {
  std::span<DatasetRequest> datasets;  // At least one.
  std::string picture_file;
};

// Sorts the datasets by time. Several times have a picture each, named like the first dataset's
// last part: flow_t0003.png.
[[nodiscard]] std::vector<Scene> scenes_of(const std::filesystem::path& picture,
                                           ConnectedRequests& connected);

// Returns opacity and color for each ordered surface: one for all, or one for each, colors as
// "#rrggbb". By default, a dataset's only surface has the dataset's color. Returns
// kInvalidArgument, naming the option.
[[nodiscard]] Result<std::vector<DrawnSurface>> appearances_of(
    const std::vector<double>& opacities, const std::vector<std::string>& surface_colors,
    std::span<const DatasetRequest> datasets);

}  // namespace multitetra
