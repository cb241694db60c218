// Tiles received from a server: checks them against their step, and assembles them to a mesh.
#pragma once

#include <cstddef>

#include "common/wire/messages.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {

// Returns the encoded size of all tiles with their scalars.
[[nodiscard]] std::size_t bytes_of_tiles(const StepBegin& step);

// Returns kDamagedData, naming the first difference, if the payload does not match the step's tile
// summary. Decodes the payload, which takes a few milliseconds. Does not throw.
[[nodiscard]] Result<void> check_tile(const EncodedTile& tile, const StepBegin& step);

}  // namespace multitetra
