// The refined cubes of a model in groups where a threshold map allows about the same: so that a few
// cubes of each group stand for it, and a small region of small thresholds is not overlooked.
#pragma once

#include <stop_token>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/fine_errors/prepared_model.hpp"

namespace multitetra {

struct CubeGroup {
  std::vector<OctreeCube> cubes;  // Of CubeSample::kExponent, in octree order.
  // Triangles, roughly, from the spectrum and the thresholds alone: of the model's surface,
  double extracted = 0;
  double left = 0;  // and of what simplification leaves of it.
};

// Grouped by the octave of the least threshold in the cube's parent. At most eight groups; one,
// when thresholds are the same everywhere. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] std::vector<CubeGroup> cubes_by_threshold(const PreparedModel& model, bool simplify,
                                                        const std::stop_token& stop);

}  // namespace multitetra
