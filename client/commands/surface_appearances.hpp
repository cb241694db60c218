// The opacities and colors of the surfaces in a picture.
#pragma once

#include <span>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "client/commands/snapshot_command.hpp"
#include "common/picture/rasterizer.hpp"

namespace multitetra {

// Returns opacity and color for each ordered surface. By default, a dataset's only surface has the
// dataset's color. Returns kInvalidArgument, naming the option.
[[nodiscard]] Result<std::vector<DrawnSurface>> appearances_of(
    const SnapshotArguments& arguments, std::span<const DatasetRequest> datasets);

}  // namespace multitetra
