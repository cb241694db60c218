#include "server/service/surface.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/mesh/merged_tiles.hpp"
#include "common/wire/scalar_codes.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {
namespace {

// The mesh of tile i, decoded if necessary.
Result<std::shared_ptr<const LatticeMesh>> mesh_of_tile(const ReceivedSurface& tiles,
                                                        std::size_t i) {
  if (!tiles.meshes.empty()) return tiles.meshes[i];
  if (!tiles.payloads[i]) {
    return fail(ErrorCode::kDamagedData, "Tile " + std::to_string(i) + " is missing.");
  }
  const IsosurfaceRequest& request = tiles.begin.request;
  auto decoded = decode_tile(*tiles.payloads[i], tiles.begin.tiles[i], request.lattice_resolution,
                             request.normal_bits);
  if (!decoded) return tl::unexpected(decoded.error());
  return std::make_shared<const LatticeMesh>(*std::move(decoded));
}

// The same with its scalars, its elements sorted, so that encoded tiles give the same mesh.
Result<LatticeMesh> canonical_tile(const ReceivedSurface& tiles, std::size_t i) {
  const auto tile = mesh_of_tile(tiles, i);
  if (!tile) return tl::unexpected(tile.error());
  LatticeMesh mesh = in_canonical_order(**tile);
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

// The digest of a surface is the sum of those of its tiles, which are checked as they are decoded.
Result<void> check_digest(const ReceivedSurface& tiles) {
  ContentDigest all;
  for (const TileSummary& tile : tiles.begin.tiles) all += tile.digest;
  if (all == tiles.digest) return {};
  return fail(ErrorCode::kDamagedData,
              "The surface does not match its manifest: this is a bug in the server.");
}

Surface without_mesh(const ReceivedSurface& tiles) {
  const StepBegin& begin = tiles.begin;
  Surface surface{.request = begin.request,
                  .error_bound_world = begin.error_bound_world,
                  .finest_spacing = begin.finest_spacing,
                  .crossed_octants = begin.crossed_octants,
                  .tetrahedra = begin.tetrahedra,
                  .active_tetrahedra = begin.active_tetrahedra,
                  .tiles = begin.tiles.size(),
                  .scalars = begin.scalars,
                  .digest = tiles.digest};
  for (const TileSummary& tile : begin.tiles) {
    surface.simplification_bound =
        std::max(surface.simplification_bound, tile.simplification_bound);
  }
  return surface;
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

Result<Surface> assembled(ReceivedSurface tiles, const std::stop_token& stop) {
  if (const auto matches = check_digest(tiles); !matches) return tl::unexpected(matches.error());
  const std::vector<std::size_t> order = order_by_cube(tiles.begin.tiles);
  std::vector<Result<LatticeMesh>> made(order.size());
  in_parallel(
      order.size(),
      [&](std::size_t i) {
        made[i] = canonical_tile(tiles, order[i]);
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
  Surface surface = without_mesh(tiles);
  surface.mesh = weld(pointers, surface.request.lattice_resolution);
  return surface;
}

Result<CountedSurface> assembled_and_counted(ReceivedSurface tiles, const DatasetInfo& info,
                                             const std::stop_token& stop) {
  if (const auto matches = check_digest(tiles); !matches) return tl::unexpected(matches.error());
  const std::vector<std::size_t> order = order_by_cube(tiles.begin.tiles);
  std::vector<Result<std::shared_ptr<const LatticeMesh>>> made(order.size());
  const ForEachTile for_each = [&](std::size_t count,
                                   const std::function<void(std::size_t)>& body) {
    in_parallel(count, body, stop);
  };
  for_each(order.size(), [&](std::size_t i) { made[i] = mesh_of_tile(tiles, order[i]); });
  std::vector<TileInCube> in_cubes;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!made[i]) return tl::unexpected(made[i].error());
    in_cubes.push_back({.mesh = made[i]->get(), .cube = tiles.begin.tiles[order[i]].cube});
  }
  CountedSurface counted{.surface = without_mesh(tiles)};
  const IsosurfaceRequest& request = counted.surface.request;
  const DataBorder border = data_border(info, request.lattice_resolution,
                                        request.topology_tolerance, counted.surface.finest_spacing);
  if (request.simplify) {  // Its tiles may reach beyond the faces of their cubes.
    std::vector<const LatticeMesh*> meshes;
    for (const TileInCube& tile : in_cubes) meshes.push_back(tile.mesh);
    counted.surface.mesh = weld(meshes, request.lattice_resolution);
    counted.topology = topology(counted.surface.mesh, border);
    return counted;
  }
  MergedTiles merged = merged_tiles(in_cubes, request.lattice_resolution, border, for_each);
  counted.surface.mesh = std::move(merged.mesh);
  counted.topology = merged.topology;
  return counted;
}

}  // namespace multitetra
