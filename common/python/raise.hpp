// Python exceptions out of C++.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <type_traits>
#include <utility>

#include "common/base/result.hpp"

namespace multitetra {

[[noreturn]] inline void raise(PyObject* type, const std::string& text) {
  PyErr_SetString(type, text.c_str());
  throw pybind11::error_already_set();
}

// Returns the value of a parsed argument; raises ValueError if it is invalid.
template <typename T>
T argument(Result<T> result) {
  if (!result) raise(PyExc_ValueError, result.error().text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace multitetra
