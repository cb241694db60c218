// Rows of three numbers as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "common/python/raise.hpp"

namespace multitetra {

// Returns an array of shape (count, 3) with the rows row(0), row(1), ...
template <typename T, typename Row>
pybind11::object new_rows(std::size_t count, const Row& row) {
  pybind11::array_t<T> array({static_cast<pybind11::ssize_t>(count), pybind11::ssize_t{3}});
  T* out = array.mutable_data();
  for (std::size_t i = 0; i < count; ++i) {
    const auto numbers = row(i);
    out = std::copy(numbers.begin(), numbers.end(), out);
  }
  return array;
}

template <typename T, typename Rows>
pybind11::object rows_of(const Rows& rows) {
  return new_rows<T>(rows.size(), [&](std::size_t i) { return rows[i]; });
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
