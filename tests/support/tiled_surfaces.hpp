// Tiles of a surface as one mesh, and as triangles to measure distances from.
#pragma once

#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/surface_distance.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra::testing {

inline LatticeMesh mesh_of(const TiledMesh& surface, int resolution = kDefaultLatticeResolution) {
  return weld(surface.tiles, resolution);
}

// With Draco, in order, on all threads.
inline std::vector<EncodedTile> encode_tiles(const TiledMesh& surface) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(encoded.size(), [&](std::size_t i) {
    const TileMesh& tile = surface.tiles[i];
    encoded[i] = encode_tile(tile.mesh, tile.cube, encoding_speed(tile));
  });
  return encoded;
}

// In world units along the grid's axes.
inline std::vector<SurfaceTriangle> placed(const LatticeMesh& mesh, const DatasetInfo& info) {
  std::vector<SurfaceTriangle> surface;
  for (const TriangleIndices& t : mesh.triangles) {
    SurfaceTriangle& triangle = surface.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = grid_coordinates(mesh.vertices[t[i]], mesh.resolution);
      triangle[i] = {info.spacing[0] * p[0], info.spacing[1] * p[1], info.spacing[2] * p[2]};
    }
  }
  return surface;
}

}  // namespace multitetra::testing
