// Traversal of a model's tetrahedra: those that no kept point divides.
#pragma once

#include "common/mesh/octree_cube.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/framework/tetrahedron.hpp"

namespace multitetra {

// Returns the octree cube that covers the whole grid.
[[nodiscard]] constexpr OctreeCube root_cube(const Grid& grid) {
  return {grid.exponent(), 0, 0, 0};
}

// Returns whether the model fills the cube with twelve tetrahedra (or refinements of them), that
// is, whether it keeps the cube's center.
[[nodiscard]] inline bool is_refined(const Model& model, const Grid& grid, const OctreeCube& cube) {
  return cube.exponent >= 1 && (cube == root_cube(grid) || model.kept(center(cube)));
}

// Calls `visit(tetrahedron)` in a fixed order for the tetrahedra of the model that lie in `cube`
// but not in a refined child of it; there are at most 48. Requires is_refined(model, grid, cube).
template <typename Visit>
void visit_own_leaves(const Model& model, const OctreeCube& cube, const Visit& visit) {
  const auto walk = [&](const auto& self, const Tetrahedron& t) -> void {
    if (!t.is_divisible() || !model.kept(t.dividing_point())) {
      visit(t);
    } else if (t.kind != PointKind::kCube) {  // The halves at a cube point lie in a refined child.
      for (const Tetrahedron& half : t.bisect()) self(self, half);
    }
  };
  for (const Tetrahedron& t : tetrahedra_of(cube)) walk(walk, t);
}

// Calls `visit(tetrahedron)` for all tetrahedra of the model in a refined cube, children first.
template <typename Visit>
void visit_leaves(const Model& model, const Grid& grid, const OctreeCube& cube,
                  const Visit& visit) {
  for (int i = 0; i < 8; ++i) {
    if (is_refined(model, grid, cube.child(i))) visit_leaves(model, grid, cube.child(i), visit);
  }
  visit_own_leaves(model, cube, visit);
}

}  // namespace multitetra
