// Compares every component of a mesh with its counterpart in the full surface.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/detail/closed_components.hpp"

namespace multitetra {

// A surface with its components. Every vertex must be used.
struct SurfaceParts {
  const TriangleMesh& mesh;
  const MeshComponents& components;
  const std::vector<Facing>& facings;  // Of the components.
};

// `allowed` is a distance, in world units, within which the two surfaces lie of each other; `voxel`
// converts it to the grid steps of diagonals.
//
// Orientation: the closed components that face one way must lie within `allowed` of those of the
// other surface that face the same way, vertex by vertex and in both directions, and there must be
// as many of them (apart from those too small to face one way). Open components must agree with the
// normals of the nearest triangles. Side: some part of a component must lie inside the same large
// ones as a component of about its size does there. The error may carry components smaller than
// twice `allowed` through a wall; these are not compared.
[[nodiscard]] ComponentFaults compared_components(const SurfaceParts& mesh,
                                                  const SurfaceParts& full, double allowed,
                                                  double voxel);

}  // namespace multitetra
