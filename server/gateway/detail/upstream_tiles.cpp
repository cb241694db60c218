#include "server/gateway/detail/upstream_tiles.hpp"

#include <exception>
#include <string>

#include "common/wire/shell_tile.hpp"

namespace multitetra {

std::size_t bytes_of_tiles(const StepBegin& step) {
  constexpr std::size_t kBytesOfAScalar = 2;  // Per vertex.
  std::size_t bytes = 0;
  for (const TileSummary& tile : step.tiles) {
    bytes += tile.bytes + (step.scalars ? kBytesOfAScalar * tile.vertices : 0);
  }
  return bytes;
}

Result<void> check_tile(const EncodedTile& tile, const StepBegin& step) {
  const IsosurfaceRequest& request = step.request;
  try {
    const auto decoded = step.shell
                             ? decode_shell_tile(*tile.payload, tile.summary,
                                                 {.lattice_resolution = request.lattice_resolution,
                                                  .finest_spacing = step.finest_spacing,
                                                  .shell = *step.shell})
                             : decode_tile(*tile.payload, tile.summary, request.lattice_resolution,
                                           request.normal_bits);
    if (!decoded) return tl::unexpected(decoded.error());
    return {};
  } catch (const std::exception& failure) {
    return fail(ErrorCode::kDamagedData,
                std::string("The tile cannot be decoded: ") + failure.what());
  }
}

}  // namespace multitetra
