#include "server/extraction/detail/parallel_surface.hpp"

#include <algorithm>

namespace multitetra {
namespace {

void append_refined_cubes(const CubeExtractor& extractor, const OctreeCube& cube, int exponent,
                          std::vector<OctreeCube>& cubes) {
  if (cube.exponent == exponent) {
    cubes.push_back(cube);
    return;
  }
  for (int i = 0; i < 8; ++i) {
    const OctreeCube child = cube.child(i);
    if (extractor.is_refined(child)) append_refined_cubes(extractor, child, exponent, cubes);
  }
}

// Joins the surfaces of those cubes, which come in the order of append_refined_cubes, up to `cube`.
CubeSurface join(const CubeExtractor& extractor, const OctreeCube& cube, int exponent,
                 std::vector<CubeSurface>::iterator& next) {
  if (cube.exponent == exponent) return std::move(*next++);
  std::vector<CubeSurface> children(8);
  for (int i = 0; i < 8; ++i) {
    if (extractor.is_refined(cube.child(i))) {
      children[static_cast<std::size_t>(i)] = join(extractor, cube.child(i), exponent, next);
    }
  }
  return extractor.join(cube, std::move(children));
}

}  // namespace

TiledSurface extract_in_parallel(const CubeExtractor& extractor, const OctreeCube& root,
                                 int exponent, std::stop_token stop) {
  exponent = std::min(exponent, root.exponent);
  std::vector<OctreeCube> cubes;
  append_refined_cubes(extractor, root, exponent, cubes);
  extractor.will_extract(cubes);
  std::vector<CubeSurface> parts(cubes.size());
  in_parallel(
      cubes.size(), [&](std::size_t i) { parts[i] = extractor.surface_in(cubes[i]); }, stop);

  auto next = parts.begin();
  CubeSurface whole = join(extractor, root, exponent, next);
  TiledSurface surface{
      .tetrahedra = whole.tetrahedra, .active_tetrahedra = whole.active_tetrahedra, .tiles = {}};
  surface.tiles = finished_tiles(std::move(whole), root);
  return surface;
}

std::vector<EncodedTile> encode_tiles(const TiledSurface& surface, std::stop_token stop) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(
      encoded.size(),
      [&](std::size_t i) {
        const TileMesh& tile = surface.tiles[i];
        encoded[i] = encode_tile(tile.mesh, tile.cube, encoding_speed(tile));
      },
      stop);
  return encoded;
}

}  // namespace multitetra
