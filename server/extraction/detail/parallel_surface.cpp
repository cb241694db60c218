#include "server/extraction/detail/parallel_surface.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "common/base/parallel_tree.hpp"

namespace multitetra {
namespace {

struct ExtractedCube {
  OctreeCube cube;
  bool is_leaf = true;
  std::array<std::optional<std::size_t>, 8> children = {};  // The refined ones.
  CubeSurface surface = {};
};

// Appends the cube after its refined descendants, down to `exponent`. Returns its number.
std::size_t append_cubes(const CubeExtractor& extractor, const OctreeCube& cube, int exponent,
                         std::vector<ExtractedCube>& tree, std::vector<std::size_t>& parents) {
  ExtractedCube added{.cube = cube, .is_leaf = cube.exponent == exponent};
  for (std::size_t i = 0; !added.is_leaf && i < 8; ++i) {
    const OctreeCube child = cube.child(static_cast<int>(i));
    if (!extractor.is_refined(child)) continue;
    added.children[i] = append_cubes(extractor, child, exponent, tree, parents);
  }
  const std::size_t number = tree.size();
  for (const auto& child : added.children) {
    if (child) parents[*child] = number;
  }
  tree.push_back(std::move(added));
  parents.push_back(number);
  return number;
}

// Returns the surface in a cube whose children are complete.
CubeSurface surface_in(const CubeExtractor& extractor, std::vector<ExtractedCube>& tree,
                       const ExtractedCube& here) {
  if (here.is_leaf) return extractor.surface_in(here.cube);
  std::vector<CubeSurface> children(8);
  for (std::size_t i = 0; i < 8; ++i) {
    if (here.children[i]) children[i] = std::move(tree[*here.children[i]].surface);
  }
  return extractor.join(here.cube, std::move(children));
}

void take_all(const TakeTile& take, std::vector<TileMesh> tiles) {
  for (TileMesh& tile : tiles) take(std::move(tile));
}

}  // namespace

TiledMesh extract_in_parallel(const CubeExtractor& extractor, const OctreeCube& root, int exponent,
                              std::stop_token stop, const TakeTile& take) {
  exponent = std::min(exponent, root.exponent);
  std::vector<ExtractedCube> tree;
  std::vector<std::size_t> parents;
  append_cubes(extractor, root, exponent, tree, parents);
  std::vector<OctreeCube> cubes;
  for (const ExtractedCube& here : tree) {
    if (here.is_leaf) cubes.push_back(here.cube);
  }
  extractor.will_extract(cubes);
  in_parallel_upwards(
      parents,
      [&](std::size_t i) {
        CubeSurface& surface = tree[i].surface;
        surface = surface_in(extractor, tree, tree[i]);
        if (take) take_all(take, std::exchange(surface.tiles, {}));
      },
      stop);
  CubeSurface whole = std::move(tree.back().surface);
  TiledMesh surface{
      .tetrahedra = whole.tetrahedra, .active_tetrahedra = whole.active_tetrahedra, .tiles = {}};
  surface.tiles = finished_tiles(std::move(whole), root);
  if (take) take_all(take, std::exchange(surface.tiles, {}));
  return surface;
}

}  // namespace multitetra
