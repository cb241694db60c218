#include "server/python/array_slices.hpp"

#include <utility>
#include <vector>

namespace py = pybind11;

namespace multitetra {

ArraySlices::ArraySlices(py::function fill, const std::array<std::int64_t, 3>& shape,
                         StoredType type)
    : fill_(std::move(fill)), shape_(shape), type_(type) {}

ArraySlices::~ArraySlices() {
  const py::gil_scoped_acquire held;
  fill_ = py::function();
}

void ArraySlices::read(std::size_t first, std::size_t count, std::byte* into) {
  const py::gil_scoped_acquire held;
  const py::dtype type =
      with_number_type(type_, []<typename Number>() { return py::dtype::of<Number>(); });
  const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(count), shape_[1], shape_[2]};
  const py::array view(type, shape, into, py::none());  // None owns it, so it is no copy.
  fill_(first, first + count, view);
}

}  // namespace multitetra
