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
  std::shared_ptr<const std::string> codes;  // See TileScalars.
  double largest_deviation = 0;
};

// Computes the scalars of all tiles, in order and on all threads, for a step of `request` on the
// dataset `surface`. Fails with kDamagedData, an internal error, if a tile cannot be decoded.
// Throws Cancelled soon after `stop` is triggered, and rethrows exceptions from reading the field.
[[nodiscard]] Result<std::vector<ScalarsOfTile>> step_scalars(
    const EncodedStep& step, const IsosurfaceRequest& request, const DatasetInfo& surface,
    const PreparedVolume& field, const ScalarRange& range, std::stop_token stop);

// Returns the total size of the codes.
[[nodiscard]] std::size_t bytes_of(const std::vector<ScalarsOfTile>& scalars);

}  // namespace multitetra
