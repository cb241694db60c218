// Tiles received from a server: checks them against their step, and assembles them to a mesh.
#pragma once

#include <cstddef>
#include <stop_token>

#include "common/wire/messages.hpp"
#include "common/wire/tile.hpp"
#include "server/service/surface.hpp"

namespace multitetra {

// Returns the encoded size of all tiles with their scalars.
[[nodiscard]] std::size_t bytes_of_tiles(const StepBegin& step);

// Returns kDamagedData, naming the first difference, if the payload does not match the step's tile
// summary. Decodes the payload, which takes a few milliseconds. Does not throw.
[[nodiscard]] Result<void> check_tile(const EncodedTile& tile, const StepBegin& step);

// Same as assembled(), but returns exceptions as errors.
[[nodiscard]] Result<Surface> try_assemble(SurfaceTiles tiles, const std::stop_token& stop);

}  // namespace multitetra
