#include "server/core/planning/simplified_size.hpp"

#include <algorithm>
#include <cmath>

#include "server/core/simplification/simplified_cube.hpp"

namespace multitetra {
namespace {

constexpr double kFewBorderEdges = 50;  // Fewer are no basis for an estimate.
// Minimum fraction of the triangles left in blocks: every tile keeps some.
constexpr double kMinInnerShare = 0.05;

}  // namespace

double estimate_triangles_per_border_edge(const SimplifiedBlocks& apart,
                                          const SimplifiedBlocks& joined) {
  const double edges = apart.border_edges - joined.border_edges;
  if (edges < kFewBorderEdges) {
    return apart.before > 0 ? 1 - 0.6 * std::sqrt(std::min(apart.left / apart.before, 1.0)) : 1;
  }
  return std::clamp((apart.left - joined.left) / edges, 0.0, 1.0);
}

double remaining_share(const SimplifiedBlocks& blocks, double triangles_per_border_edge,
                       double before) {
  if (blocks.before <= 0) return 1;
  const double remaining = blocks.left / blocks.before;
  const double at_border = triangles_per_border_edge * blocks.border_edges / blocks.before;
  const double inner = std::max(remaining - at_border, kMinInnerShare * remaining);
  const SimplifiedTileLimits limits;
  // The average fill of tiles. A tile that contains everything has no border.
  const double triangles = 0.6 * static_cast<double>(limits.triangles);
  if (inner * before <= static_cast<double>(limits.triangles) &&
      before <= 2 * static_cast<double>(limits.vertices_before)) {
    return std::min(inner, 1.0);
  }
  const double blocks_of_tile =
      std::min(triangles / (inner * blocks.before / static_cast<double>(blocks.count)),
               2 * static_cast<double>(limits.vertices_before) * static_cast<double>(blocks.count) /
                   blocks.before);
  const double sides = std::sqrt(std::max(blocks_of_tile, 1.0));
  return std::min(inner + (remaining - inner) / sides, 1.0);
}

double rough_remaining_share(double voxels) {
  // The power 5/4 by roots, which give the same bits on every machine.
  const double at_least = std::max(voxels, 0.01);
  return std::min(0.018 / (at_least * std::sqrt(std::sqrt(at_least))), 0.5);
}

}  // namespace multitetra
