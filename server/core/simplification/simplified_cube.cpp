#include "server/core/simplification/simplified_cube.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace multitetra {
namespace {

void cut_off(SimplifiedCube& child, std::vector<SimplifiedTile>& tiles) {
  if (child.rest.triangles() > 0) tiles.push_back({child.cube, std::move(child.rest)});
}

}  // namespace

SimplifiedCube join_simplified(const OctreeCube& cube, std::vector<SimplifiedCube> children,
                               std::optional<SimplifiedPiece> own,
                               const SimplificationOptions& options,
                               const SimplifiedTileLimits& limits,
                               const std::function<void()>& checkpoint, Obstacles obstacles) {
  SimplifiedCube joined{.cube = cube, .tiles = {}, .rest = {}};
  // With `is_intersection_free`: obstacles other than the pieces themselves.
  std::vector<LatticeTriangle> others(obstacles.begin(), obstacles.end());
  const auto all_obstacles = [&] {
    return options.is_intersection_free ? std::optional(Obstacles(others)) : std::nullopt;
  };
  if (options.is_intersection_free) {
    for (const SimplifiedCube& child : children) {
      for (const SimplifiedTile& tile : child.tiles) tile.piece.append_triangles(others);
    }
  }
  const std::size_t without_rest = others.size();
  std::vector<SimplifiedPiece> pieces;
  const int stage = 2 * cube.exponent;
  const bool is_begun = own && own->is_new();
  if (own) {
    if (options.is_intersection_free) {
      for (const SimplifiedCube& child : children) child.rest.append_triangles(others);
    }
    if (is_begun) own->begin(options.max_distance, all_obstacles(), checkpoint);
    if (options.is_resumable) own->record_history();
    if (!is_begun) own->simplify(options.max_distance, checkpoint, all_obstacles(), stage);
    pieces.push_back(*std::move(own));
    others.resize(without_rest);
  }
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
      if (options.is_intersection_free) child.rest.append_triangles(others);
      if (!options.is_resumable) child.rest.finish();
      cut_off(child, joined.tiles);
    } else if (child.rest.triangles() > 0) {
      pieces.push_back(std::move(child.rest));
    }
  }
  const bool is_joined = pieces.size() > 1;
  if (pieces.size() == 1) {
    joined.rest = std::move(pieces.front());
  } else if (pieces.size() > 1) {
    joined.rest = SimplifiedPiece::joined(std::move(pieces));
  } else {
    return joined;
  }
  // A single piece is already simplified, unless only its first stage has run.
  if (is_joined || is_begun) {
    const bool is_last = cube.exponent == limits.root_exponent && !options.is_resumable;
    joined.rest.simplify(options.max_distance, checkpoint, all_obstacles(), stage + 1, is_last);
  }
  return joined;
}

std::vector<SimplifiedTile> all_tiles(SimplifiedCube root) {
  std::vector<SimplifiedTile> tiles = std::move(root.tiles);
  cut_off(root, tiles);
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra
