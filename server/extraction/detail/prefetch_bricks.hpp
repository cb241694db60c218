// Prefetches the bricks that a surface will need from a remote dataset.
#pragma once

#include <cstdint>
#include <span>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// Announces extraction of the surface in these cubes, for a model with this finest spacing:
// prefetches the bricks of the spectrum around them, and samples if the model needs them. Does
// nothing for local datasets.
void prefetch_bricks(const PreparedVolume& volume, std::span<const OctreeCube> cubes,
                     std::int32_t finest_spacing);

// Returns the bytes to fetch before the spectrum of that spacing and coarser ones can be read.
[[nodiscard]] std::uint64_t spectrum_bytes_to_fetch(const PreparedVolume& volume,
                                                    std::int32_t finest_spacing);

}  // namespace multitetra
