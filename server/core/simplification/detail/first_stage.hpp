// The first stage of simplification: fast collapses with a part of the limit, so that the second
// stage, which is slower but measures exact distances, starts with fewer triangles.
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
  // Its vertices are a subset of those before, in the order of first use.
  LatticeMesh mesh;
  // By vertex, in units: see vertex_errors.hpp.
  std::vector<float> errors;
};

// Requires triangles with three different vertices each. Preserves the topology. With `obstacles`,
// a surface that intersects neither itself nor the obstacles stays intersection-free.
[[nodiscard]] FirstStage first_stage(const LatticeMesh& mesh, std::span<const Vec3> positions,
                                     const PieceLimit& limit, std::optional<Obstacles> obstacles,
                                     const std::function<void()>& checkpoint);

}  // namespace multitetra
