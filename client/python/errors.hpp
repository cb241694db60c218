// Errors of the client as Python exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <type_traits>
#include <utility>

#include "client/library/client.hpp"
#include "common/python/raise.hpp"

namespace multitetra {

// Raises ServerError, CheckError or ConnectionError; or what a signal handler has raised.
[[noreturn]] void raise(const ClientError& failure);

template <typename T>
T value_of(ClientResult<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

// Adds the exception classes to the module.
void define_errors(pybind11::module_& module);

}  // namespace multitetra
