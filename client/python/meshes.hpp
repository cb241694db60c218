// Meshes as NumPy arrays.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>

#include "common/base/affine.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

// Returns a multitetra.mesh.Mesh. Converts in double precision, so that no vertex moves; reverses
// faces if the map mirrors.
[[nodiscard]] pybind11::object mesh_of(const LatticeMesh& mesh, const Affine& grid_to_world,
                                       std::optional<double> error_bound, bool is_full_resolution);

// Adds save_mesh().
void define_meshes(pybind11::module_& module);

}  // namespace multitetra
