// Defines the contents of the Python module, by subject.
#pragma once

#include <pybind11/pybind11.h>

namespace multitetra {

void define_requests(pybind11::module_& module);
void define_datasets(pybind11::module_& module);
// Defines replies and the steps of streams.
void define_answers(pybind11::module_& module);
void define_connection(pybind11::module_& module);

}  // namespace multitetra
