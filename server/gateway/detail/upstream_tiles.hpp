// Tiles received from a server: checked against their step, and assembled to one mesh.
#pragma once

#include <cstddef>
#include <stop_token>

#include "common/wire/messages.hpp"
#include "common/wire/tile.hpp"
#include "server/service/surface.hpp"

namespace multitetra {

// Encoded, with their scalars.
[[nodiscard]] std::size_t bytes_of_tiles(const StepBegin& step);

// kDamagedData, naming the first difference, where the payload is not the step's tile of the
// summary. Decodes it, which takes a few milliseconds. Never throws.
[[nodiscard]] Result<void> check_tile(const EncodedTile& tile, const StepBegin& step);

// As assembled(), with an error where that throws.
[[nodiscard]] Result<Surface> assembled_or_why_not(SurfaceTiles tiles, const std::stop_token& stop);

}  // namespace multitetra
