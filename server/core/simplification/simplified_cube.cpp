#include "server/core/simplification/simplified_cube.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace multitetra {
namespace {

void cut_off(const SimplifiedCube& child, std::vector<TileMesh>& tiles) {
  if (child.rest.triangles() == 0) return;
  Simplified tile = child.rest.result();
  tiles.push_back(
      {.cube = child.cube, .mesh = std::move(tile.mesh), .simplification_bound = tile.bound});
}

}  // namespace

SimplifiedCube join_simplified(const OctreeCube& cube, std::vector<SimplifiedCube> children,
                               std::optional<LatticeMesh> own, const SimplificationOptions& options,
                               const SimplifiedTileLimits& limits,
                               const std::function<void()>& checkpoint) {
  SimplifiedCube joined{.cube = cube, .tiles = {}, .rest = {}};
  std::vector<SimplifiedPiece> pieces;
  if (own) pieces.emplace_back(*std::move(own), options.lattice_step);
  std::size_t triangles = own ? pieces.front().triangles() : 0;
  std::size_t vertices_before = own ? pieces.front().vertices_before() : 0;
  for (SimplifiedCube& child : children) {
    std::move(child.tiles.begin(), child.tiles.end(), std::back_inserter(joined.tiles));
    triangles += child.rest.triangles();
    vertices_before += child.rest.vertices_before();
  }
  std::stable_sort(children.begin(), children.end(), [](const auto& a, const auto& b) {
    return a.rest.triangles() > b.rest.triangles();
  });
  for (SimplifiedCube& child : children) {
    const bool is_too_much =
        triangles > limits.triangles || vertices_before > limits.vertices_before;
    if (is_too_much) {
      triangles -= child.rest.triangles();
      vertices_before -= child.rest.vertices_before();
      cut_off(child, joined.tiles);
    } else if (child.rest.triangles() > 0) {
      pieces.push_back(std::move(child.rest));
    }
  }
  if (pieces.size() == 1) {
    joined.rest = std::move(pieces.front());
    // A child's rest has been simplified.
    if (own) joined.rest.simplify(options.max_distance, checkpoint);
  } else if (pieces.size() > 1) {
    joined.rest = SimplifiedPiece::joined(std::move(pieces));
    joined.rest.simplify(options.max_distance, checkpoint);
  }
  return joined;
}

std::vector<TileMesh> finished_tiles(SimplifiedCube root) {
  std::vector<TileMesh> tiles = std::move(root.tiles);
  cut_off(root, tiles);
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra
