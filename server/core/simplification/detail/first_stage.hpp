// Simplification's first stage: quick collapses with a part of the limit, so that the second one,
// whose distances are exact and slower, begins with fewer triangles.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/base/vec3.hpp"
#include "common/mesh/mesh.hpp"
#include "server/core/simplification/detail/allowed_distance.hpp"
#include "server/core/simplification/detail/embedding.hpp"

namespace multitetra {

struct FirstStage {
  LatticeMesh mesh;  // Vertices are some of those before, in the order of their first use.
  // By vertex, in units: see vertex_errors.hpp.
  std::vector<float> errors;
};

// Requires triangles of three different vertices each. The topology is kept as by simplification;
// with `embedded` what does not cut itself or the obstacles does not afterwards.
[[nodiscard]] FirstStage first_stage(const LatticeMesh& mesh, std::span<const Vec3> positions,
                                     const PieceLimit& limit, std::optional<Obstacles> embedded,
                                     const std::function<void()>& checkpoint);

}  // namespace multitetra
