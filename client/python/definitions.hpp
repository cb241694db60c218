// What the module has, by subject.
#pragma once

#include <pybind11/pybind11.h>

namespace multitetra {

void define_requests(pybind11::module_& module);
void define_datasets(pybind11::module_& module);
// Replies and steps of streams.
void define_answers(pybind11::module_& module);
void define_connection(pybind11::module_& module);

}  // namespace multitetra
