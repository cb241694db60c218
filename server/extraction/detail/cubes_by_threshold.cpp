#include "server/extraction/detail/cubes_by_threshold.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/core/planning/surface_size.hpp"
#include "server/core/simplification/threshold_shares.hpp"

namespace multitetra {
namespace {

// Returns the typical number of triangles of a full surface in a refined cube of 16 steps, by the
// allowed error in voxels. Public volumes have 560 to 970 at a quarter of a voxel, 380 to 740 at
// one voxel, 270 to 560 at two.
double triangles_a_cube(double voxels) { return 600 / (1 + 0.6 * voxels); }

// Returns the octave of a threshold in voxels, clamped where surfaces hardly differ.
int octave(double voxels) {
  constexpr int kLowest = -4;
  constexpr int kHighest = 3;
  return voxels > 0 ? std::clamp(std::ilogb(voxels), kLowest, kHighest) : kLowest;
}

}  // namespace

std::vector<CubeGroup> cubes_by_threshold(const PreparedModel& model, bool simplify,
                                          const std::stop_token& stop) {
  const double voxel = voxel_length(model.volume().info);
  const double share = simplify ? kModelShare : 1;
  const auto voxels_in = [&](const OctreeCube& cube) {
    return model.thresholds().least_in(box_of(cube)) / voxel;
  };
  std::map<int, CubeGroup> groups;
  visit_refined_cubes(model, CubeSample::kExponent, [&](const OctreeCube& cube) {
    throw_if_stopped(stop);
    const double voxels = voxels_in(cube);
    const double triangles = triangles_a_cube(voxels);
    CubeGroup& group = groups[octave(voxels_in(cube.parent()) / share)];
    group.cubes.push_back(cube);
    group.extracted += triangles;
    group.left += triangles * (simplify ? rough_remaining_share(voxels / share) : 1);
  });
  std::vector<CubeGroup> sorted;
  for (auto& [unused, group] : groups) sorted.push_back(std::move(group));
  return sorted;
}

}  // namespace multitetra
