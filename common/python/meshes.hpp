// Surfaces as objects of the Python package.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

// What is certain of a mesh.
struct SurfaceFacts {
  MeshTopology topology;
  ContentDigest digest;
  // Bounds the distance to the full-resolution surface, rounding included; absent: no bound.
  std::optional<double> error_bound = {};
  bool is_full_resolution = false;
  bool preserves_topology = false;
  bool is_intersection_free = false;
};

// Returns vertices in world coordinates, on all threads. In double precision no vertex moves.
[[nodiscard]] std::vector<Vec3> world_vertices(const LatticeMesh& mesh,
                                               const Affine& grid_to_world);

// Returns a multitetra.mesh.Mesh with the mesh's elements and these vertices, without a copy.
// Reverses faces if the map mirrors.
[[nodiscard]] pybind11::object mesh_of(LatticeMesh mesh, std::vector<Vec3> vertices,
                                       const Affine& grid_to_world, const SurfaceFacts& facts);

}  // namespace multitetra
