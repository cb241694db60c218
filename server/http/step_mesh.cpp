#include "server/http/step_mesh.hpp"

#include <string>
#include <utility>
#include <vector>

#include "common/wire/scalar_codes.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {

Result<LatticeMesh> welded_mesh(const OneShotSession::Step& step, const std::stop_token& stop) {
  const IsosurfaceRequest& request = step.begin.request;
  std::vector<LatticeMesh> tiles;
  tiles.reserve(step.payloads.size());
  for (std::size_t i = 0; i < step.payloads.size(); ++i) {
    if (stop.stop_requested()) return fail(ErrorCode::kCancelled, "The client is gone.");
    if (!step.payloads[i]) {
      return fail(ErrorCode::kDamagedData, "Tile " + std::to_string(i) + " did not come.");
    }
    auto tile = decode_tile(*step.payloads[i], step.begin.tiles[i], request.lattice_resolution,
                            request.normal_bits);
    if (!tile) return tl::unexpected(tile.error());
    if (step.begin.scalars) {
      if (!step.scalars[i]) {
        return fail(ErrorCode::kDamagedData,
                    "The scalars of tile " + std::to_string(i) + " did not come.");
      }
      auto values = decode_scalars(*step.scalars[i], tile->vertices, *step.begin.scalars);
      if (!values) return tl::unexpected(values.error());
      tile->scalars = *std::move(values);
    }
    tiles.push_back(*std::move(tile));
  }
  std::vector<const LatticeMesh*> pointers;
  for (const LatticeMesh& tile : tiles) pointers.push_back(&tile);
  return weld(pointers, request.lattice_resolution);
}

}  // namespace multitetra
