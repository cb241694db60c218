// Extracts, simplifies and encodes some blocks of a surface as they would be sent.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>

#include "common/mesh/octree_cube.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {

struct SampledBlocks {
  SimplifiedBlocks triangles;  // Nothing is lost without simplification.
  double bytes = 0;            // Encoded.
  double a_border_edge = 1;    // Triangles that an edge of a simplified border keeps.
};

struct BlockCounts {
  std::size_t blocks = 0;  // Twice as large as the cubes that are given, spread over them.
  // So many of them with their neighbours, joined to ones that are twice as large once more: what
  // a border keeps is seen there.
  std::size_t joined = 0;
};

// Around some of the `cubes`, which are of CubeSample::kExponent and in octree order. nullopt when
// the blocks hold nothing, or the grid is too small for them. Throws Cancelled soon after `stop` is
// triggered.
[[nodiscard]] std::optional<SampledBlocks> sampled_blocks(const SurfaceExtractor& extractor,
                                                          const PreparedModel& model,
                                                          std::span<const OctreeCube> cubes,
                                                          const ResolvedStep& spec,
                                                          const BlockCounts& counts,
                                                          const std::stop_token& stop);

}  // namespace multitetra
