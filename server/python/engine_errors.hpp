// Errors of the engine as Python exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>
#include <utility>

#include "common/base/result.hpp"

namespace multitetra {

// Adds VolumeError, and raises it for volumes and datasets that cannot be read.
void define_engine_errors(pybind11::module_& module);

// Returns the text with options of the command line as keywords: "--subtract 1000" is
// "subtract=1000".
[[nodiscard]] std::string with_keywords(std::string_view text);

// Raises the exception of an error: ValueError, or RuntimeError for faults of the program.
[[noreturn]] void raise(const Error& error);

template <typename T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return *std::move(result);
}

}  // namespace multitetra
