#include "server/service/surface.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/wire/scalar_codes.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {
namespace {

Result<LatticeMesh> tile_of(const ReceivedSurface& tiles, std::size_t i, TileOrder order) {
  const IsosurfaceRequest& request = tiles.begin.request;
  LatticeMesh mesh;
  if (tiles.meshes.empty()) {
    if (!tiles.payloads[i]) {
      return fail(ErrorCode::kDamagedData, "Tile " + std::to_string(i) + " is missing.");
    }
    auto decoded = decode_tile(*tiles.payloads[i], tiles.begin.tiles[i], request.lattice_resolution,
                               request.normal_bits);
    if (!decoded) return decoded;
    mesh = *std::move(decoded);
  } else {
    mesh = *tiles.meshes[i];
  }
  if (order == TileOrder::kCanonical) mesh = in_canonical_order(mesh);
  if (tiles.begin.scalars) {
    if (!tiles.scalars[i]) {
      return fail(ErrorCode::kDamagedData,
                  "The scalars of tile " + std::to_string(i) + " are missing.");
    }
    auto values = decode_scalars(*tiles.scalars[i], mesh.vertices, *tiles.begin.scalars);
    if (!values) return tl::unexpected(values.error());
    mesh.scalars = *std::move(values);
  }
  return mesh;
}

// Makes the result independent of the tile order of the stream.
std::vector<std::size_t> order_by_cube(const std::vector<TileSummary>& tiles) {
  std::vector<std::size_t> order(tiles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return tiles[a].cube < tiles[b].cube; });
  return order;
}

}  // namespace

std::uint64_t triangles_of(const StepBegin& step) {
  std::uint64_t sum = 0;
  for (const TileSummary& tile : step.tiles) sum += tile.triangles;
  return sum;
}

std::size_t bytes_of(const LatticeMesh& mesh) {
  return mesh.vertices.size() * sizeof(LatticePoint) +
         mesh.triangles.size() * sizeof(TriangleIndices) +
         mesh.normals.size() * sizeof(UnitVector) + mesh.scalars.size() * sizeof(float);
}

Result<void> check_triangles(const StepBegin& step, std::uint64_t max_triangles) {
  const std::uint64_t triangles = triangles_of(step);
  if (triangles <= max_triangles) return {};
  return fail(ErrorCode::kLimitExceeded,
              "The mesh has " + std::to_string(triangles) +
                  " triangles; one response may have at most " + std::to_string(max_triangles) +
                  "; allow a larger error, set max_triangles, or request it as a stream.");
}

Result<Surface> assembled(ReceivedSurface tiles, const std::stop_token& stop,
                          TileOrder tile_order) {
  // The digest of a surface is the sum of those of its tiles, which are checked as they are
  // decoded.
  ContentDigest all;
  for (const TileSummary& tile : tiles.begin.tiles) all += tile.digest;
  if (all != tiles.digest) {
    return fail(ErrorCode::kDamagedData,
                "The surface does not match its manifest: this is a bug in the server.");
  }
  const std::vector<std::size_t> order = order_by_cube(tiles.begin.tiles);
  std::vector<Result<LatticeMesh>> made(order.size());
  in_parallel(
      order.size(),
      [&](std::size_t i) {
        made[i] = tile_of(tiles, order[i], tile_order);
        if (tiles.meshes.empty()) return;
        // Releases each tile early, to not hold two complete meshes.
        tiles.meshes[order[i]].reset();
      },
      stop);
  std::vector<const LatticeMesh*> pointers;
  for (const Result<LatticeMesh>& tile : made) {
    if (!tile) return tl::unexpected(tile.error());
    pointers.push_back(&*tile);
  }
  Surface surface{.request = std::move(tiles.begin.request),
                  .error_bound_world = tiles.begin.error_bound_world,
                  .finest_spacing = tiles.begin.finest_spacing,
                  .crossed_octants = tiles.begin.crossed_octants,
                  .tetrahedra = tiles.begin.tetrahedra,
                  .active_tetrahedra = tiles.begin.active_tetrahedra,
                  .tiles = tiles.begin.tiles.size(),
                  .scalars = tiles.begin.scalars,
                  .digest = tiles.digest};
  for (const TileSummary& tile : tiles.begin.tiles) {
    surface.simplification_bound =
        std::max(surface.simplification_bound, tile.simplification_bound);
  }
  surface.mesh = weld(pointers, surface.request.lattice_resolution);
  return surface;
}

}  // namespace multitetra
