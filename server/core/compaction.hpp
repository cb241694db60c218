// The same surface with fewer triangles.
//
//   const Compacted tile = compacted(mesh, {.step = {delta, delta, delta}, .budget = 0.25});
//
// Edges collapse onto one of their ends, so that every vertex that is left is one of the vertices
// before. What is guaranteed:
//
//  * no point of either surface is farther from the other than `bound`, which is at most the budget
//    (see carried_surface.hpp for the proof);
//  * the border, and every vertex without a closed ring of triangles around it, is as before:
//    meshes that fit together still do;
//  * the topology is the same: what was a manifold is one, with the same components and Euler
//    characteristic; a component without border keeps four triangles at least;
//  * no triangle turns by as much as a right angle in a collapse, and none is degenerate;
//  * the result is a function of the arguments alone, to the bit.
//
// With a budget of 0 nothing changes.
#pragma once

#include "common/affine.hpp"
#include "common/mesh.hpp"

namespace multitetra {

struct CompactionOptions {
  Vec3 step = {1, 1, 1};  // Length of a lattice step along each axis.
  double budget = 0;      // Finite and >= 0, in the unit of `step`.
};

struct Compacted {
  LatticeMesh mesh;  // Vertices in the order in which its triangles first use them. No normals.
  double bound = 0;
};

// Requires triangles of three different vertices each.
[[nodiscard]] Compacted compacted(const LatticeMesh& mesh, const CompactionOptions& options);

}  // namespace multitetra
