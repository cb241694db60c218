// Defines the contents of the module, by subject.
#pragma once

#include <pybind11/pybind11.h>

namespace multitetra {

void define_sources(pybind11::module_& module);
void define_volumes(pybind11::module_& module);
void define_certificates(pybind11::module_& module);
void define_parts(pybind11::module_& module);

}  // namespace multitetra
