// Rows of three numbers as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/python/raise.hpp"

namespace multitetra {

// Returns an array of shape (n, 3) that owns the rows, a vector of arrays of three numbers or
// another container with data() and size().
template <typename T, typename RowsOfThree>
pybind11::object rows_of(RowsOfThree rows) {
  static_assert(sizeof(*rows.data()) == 3 * sizeof(T));
  const auto size = static_cast<pybind11::ssize_t>(rows.size());
  auto* const owned = new RowsOfThree(std::move(rows));
  const pybind11::capsule owner(
      owned, [](void* rows_of_array) { delete static_cast<RowsOfThree*>(rows_of_array); });
  return pybind11::array_t<T>({size, pybind11::ssize_t{3}},
                              reinterpret_cast<const T*>(owned->data()), owner);
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
