// Surfaces as objects of the Python package.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>

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

// Returns a multitetra.mesh.Mesh. Converts in double precision, so that no vertex moves; reverses
// faces if the map mirrors.
[[nodiscard]] pybind11::object mesh_of(const LatticeMesh& mesh, const Affine& grid_to_world,
                                       const SurfaceFacts& facts);

}  // namespace multitetra
