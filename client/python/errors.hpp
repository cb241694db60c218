// Errors of the client as Python exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <type_traits>
#include <utility>

#include "client/library/client.hpp"
#include "common/base/result.hpp"

namespace multitetra {

[[noreturn]] void raise(PyObject* type, const std::string& text);
// Raises ServerError, CheckError or ConnectionError; or what a signal handler has raised.
[[noreturn]] void raise(const ClientError& failure);

template <typename T>
T value_of(ClientResult<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

// Returns the value of a parsed argument; raises ValueError if it is invalid.
template <typename T>
T argument(Result<T> result) {
  if (!result) raise(PyExc_ValueError, result.error().text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

// Adds the exception classes to the module.
void define_errors(pybind11::module_& module);

}  // namespace multitetra
