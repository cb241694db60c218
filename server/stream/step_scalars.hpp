// The scalars of a step's tiles, for streams that color their surface by a field.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/request/scalar_request.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

struct ScalarsOfTile {
  std::shared_ptr<const std::string> codes;  // As in TileScalars.
  double largest_deviation = 0;
};

// The scalars of all tiles, in their order, on all threads. `request` is that of the step,
// `surface` its dataset. kDamagedData where a tile cannot be decoded, an internal error. Throws
// Cancelled soon after `stop` is triggered, and what the field throws when it is damaged.
[[nodiscard]] Result<std::vector<ScalarsOfTile>> step_scalars(
    const TiledStep& step, const IsosurfaceRequest& request, const DatasetInfo& surface,
    const PreparedVolume& field, const ScalarRange& range, std::stop_token stop);

// The size of all of them.
[[nodiscard]] std::size_t bytes_of(const std::vector<ScalarsOfTile>& scalars);

}  // namespace multitetra
