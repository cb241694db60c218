// Mesh files of NumPy arrays.
#pragma once

#include <pybind11/pybind11.h>

namespace multitetra {

// Adds save_mesh().
void define_meshes(pybind11::module_& module);

}  // namespace multitetra
