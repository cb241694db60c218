#include "server/stream/step_scalars.hpp"

#include <optional>

#include "common/base/in_parallel.hpp"
#include "common/wire/scalar_codes.hpp"
#include "server/core/sampling/vertex_scalars.hpp"

namespace multitetra {

Result<std::vector<ScalarsOfTile>> step_scalars(const EncodedStep& step,
                                                const IsosurfaceRequest& request,
                                                const DatasetInfo& surface,
                                                const PreparedVolume& field,
                                                const ScalarRange& range, std::stop_token stop) {
  const Affine to_world = grid_to_world(surface);
  std::vector<ScalarsOfTile> scalars(step.tiles.size());
  std::vector<std::optional<Error>> damage(step.tiles.size());
  in_parallel(
      step.tiles.size(),
      [&](std::size_t i) {
        const EncodedTile& tile = step.tiles[i];
        Result<LatticeMesh> decoded;
        if (step.meshes.empty()) {
          // Caches contain only encoded tiles; decoding takes much less time than sampling.
          decoded = decode_tile(*tile.payload, tile.summary, request.lattice_resolution,
                                request.normal_bits);
          if (!decoded) {
            damage[i] = decoded.error();
            return;
          }
        }
        const LatticeMesh& mesh = step.meshes.empty() ? *decoded : *step.meshes[i];
        const VertexScalars found = vertex_scalars(field, mesh, to_world);
        scalars[i] = {.codes = std::make_shared<const std::string>(
                          encode_scalars(mesh.vertices, found.values, range)),
                      .largest_deviation = found.largest_deviation};
      },
      stop);
  for (std::optional<Error>& failure : damage) {
    if (failure) return tl::unexpected(*std::move(failure));
  }
  if (field.check) field.check();
  return scalars;
}

std::size_t bytes_of(const std::vector<ScalarsOfTile>& scalars) {
  std::size_t bytes = 0;
  for (const ScalarsOfTile& tile : scalars) bytes += tile.codes->size();
  return bytes;
}

}  // namespace multitetra
