// Extracts, simplifies and encodes a few blocks of a surface as they would be sent.
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
  SimplifiedBlocks triangles;            // Without simplification, `left` equals `before`.
  double bytes = 0;                      // Encoded.
  double triangles_per_border_edge = 1;  // Triangles per edge of a simplified border.
};

struct BlockCounts {
  std::size_t blocks = 0;  // Blocks of twice the side of the given cubes, spread over them.
  // Blocks of four times the side, simplified in octants and then joined: these show how many
  // triangles a border keeps.
  std::size_t joined = 0;
};

// Samples blocks around some of the `cubes`, which must be of CubeSample::kExponent and in octree
// order. Returns nullopt if the blocks are empty or the grid is too small for them. Throws
// Cancelled soon after `stop` is triggered.
[[nodiscard]] std::optional<SampledBlocks> sampled_blocks(const SurfaceExtractor& extractor,
                                                          const PreparedModel& model,
                                                          std::span<const OctreeCube> cubes,
                                                          const ResolvedStep& spec,
                                                          const BlockCounts& counts,
                                                          const std::stop_token& stop);

}  // namespace multitetra
