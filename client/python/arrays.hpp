// Rows of three numbers as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "client/python/errors.hpp"

namespace multitetra {

// Returns an array of shape (n, 3).
template <typename T, typename Rows>
pybind11::object rows_of(const Rows& rows) {
  const pybind11::array_t<T> array(
      {static_cast<pybind11::ssize_t>(rows.size()), pybind11::ssize_t{3}});
  T* out = const_cast<T*>(array.data());
  for (const auto& row : rows) out = std::copy(row.begin(), row.end(), out);
  return array;
}

template <typename T>
using Rows = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;

// Raises ValueError, naming `what`, unless the shape is (n, 3).
template <typename T>
std::vector<std::array<T, 3>> rows_from(const Rows<T>& rows, const char* what) {
  if (rows.ndim() != 2 || rows.shape(1) != 3) {
    raise(PyExc_ValueError, std::string(what) + " must be an array with rows of three numbers.");
  }
  std::vector<std::array<T, 3>> out(static_cast<std::size_t>(rows.shape(0)));
  const T* from = rows.data();
  for (auto& row : out) {
    std::copy_n(from, 3, row.begin());
    from += 3;
  }
  return out;
}

}  // namespace multitetra
