// Groups the refined cubes of a model by threshold, so that a few cubes can represent each group
// and a small region of small thresholds is not missed.
#pragma once

#include <stop_token>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/fine_errors/prepared_model.hpp"

namespace multitetra {

struct CubeGroup {
  std::vector<OctreeCube> cubes;  // Cubes of CubeSample::kExponent, in octree order.
  // Rough numbers of triangles, from the spectrum and the thresholds alone: of the model's surface,
  double extracted = 0;
  double left = 0;  // and of the simplified surface.
};

// Groups cubes by the octave of the least threshold in their parents: at most eight groups, or one
// for a uniform threshold. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] std::vector<CubeGroup> cubes_by_threshold(const PreparedModel& model, bool simplify,
                                                        const std::stop_token& stop);

}  // namespace multitetra
