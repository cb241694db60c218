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

void append(const TileMesh& tile, std::vector<LatticeTriangle>& triangles) {
  for (const auto& [p, q, r] : tile.mesh.triangles) {
    triangles.push_back({tile.mesh.vertices[p], tile.mesh.vertices[q], tile.mesh.vertices[r]});
  }
}

}  // namespace

SimplifiedCube join_simplified(const OctreeCube& cube, std::vector<SimplifiedCube> children,
                               std::optional<LatticeMesh> own, const SimplificationOptions& options,
                               const SimplifiedTileLimits& limits,
                               const std::function<void()>& checkpoint, Obstacles obstacles) {
  SimplifiedCube joined{.cube = cube, .tiles = {}, .rest = {}};
  // With `is_embedded`: what is in the way, besides the pieces themselves.
  std::vector<LatticeTriangle> others(obstacles.begin(), obstacles.end());
  const auto embedded = [&] {
    return options.is_embedded ? std::optional(Obstacles(others)) : std::nullopt;
  };
  if (options.is_embedded) {
    for (const SimplifiedCube& child : children) {
      for (const TileMesh& tile : child.tiles) append(tile, others);
    }
  }
  const std::size_t without_rest = others.size();
  std::vector<SimplifiedPiece> pieces;
  if (own) {
    if (options.is_embedded) {
      for (const SimplifiedCube& child : children) child.rest.append_triangles(others);
    }
    pieces.emplace_back(*std::move(own), options.lattice_step);
    pieces.front().begin(options.max_distance, embedded(), checkpoint);
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
      cut_off(child, joined.tiles);
      if (options.is_embedded) child.rest.append_triangles(others);
    } else if (child.rest.triangles() > 0) {
      pieces.push_back(std::move(child.rest));
    }
  }
  if (pieces.size() == 1) {
    joined.rest = std::move(pieces.front());
    // A child's rest has been simplified.
    if (own) joined.rest.simplify(options.max_distance, checkpoint, embedded());
  } else if (pieces.size() > 1) {
    joined.rest = SimplifiedPiece::joined(std::move(pieces));
    joined.rest.simplify(options.max_distance, checkpoint, embedded());
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
