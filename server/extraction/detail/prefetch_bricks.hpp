// Telling a dataset that is far away what a surface will look at, so that it comes together.
#pragma once

#include <cstdint>
#include <span>

#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// The surface in these cubes comes next, of a model that ends at this finest spacing: bricks of the
// spectrum around them, and of samples where the model needs these. Costs nothing where the dataset
// is on this machine.
void prefetch_bricks(const PreparedVolume& volume, std::span<const OctreeCube> cubes,
                     std::int32_t finest_spacing);

// The bytes to fetch before the spectrum of that spacing, and of coarser ones, can be
// looked at anywhere.
[[nodiscard]] std::uint64_t spectrum_bytes_to_fetch(const PreparedVolume& volume,
                                                    std::int32_t finest_spacing);

}  // namespace multitetra
