// The slices of an array-like object of Python.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Calls `fill(first, end, into)` for slices first to end - 1: it copies them to the array `into` of
// shape (end - first, height, width) and raises what prevents it. Each call takes the GIL.
class ArraySlices final : public StoredSlices {
 public:
  // `shape` is (depth, height, width).
  ArraySlices(pybind11::function fill, const std::array<std::int64_t, 3>& shape, StoredType type);
  ~ArraySlices() override;

  void read(std::size_t first, std::size_t count, std::byte* into) override;

 private:
  pybind11::function fill_;
  std::array<std::int64_t, 3> shape_;
  StoredType type_;
};

}  // namespace multitetra
