#include "client/python/definitions.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "client/python/errors.hpp"
#include "common/base/number_text.hpp"
#include "common/request/surface_query.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

// Converts a Python value to the text form of fields: numbers, strings, True as "on", sequences.
std::string text_of(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "on" : "off";
  if (py::isinstance<py::str>(value) || py::isinstance<py::int_>(value)) return py::str(value);
  if (py::hasattr(value, "__float__")) return shortest_text(value.cast<double>());
  std::string text;
  for (const py::handle each : value) text += (text.empty() ? "" : ",") + text_of(each);
  return text;
}

// Plural if the field is repeatable, because its value is then a list.
std::string keyword_of(const RequestField& field) {
  return std::string(field.name) + (field.is_repeatable ? "s" : "");
}

// Excludes fields about files, which Python users handle themselves, and the isovalue.
bool is_keyword(const RequestField& field) {
  const bool is_of_file = field.group == FieldGroup::kFile || field.name == "colors" ||
                          field.name == "color_scale" || field.name == "no_value_color";
  return !is_of_file && field.name != "isovalue";
}

void set(const RequestField& field, const py::handle& value, SurfaceQuery& query) {
  const std::string text = text_of(value);
  if (const FieldError wrong = field.set(field, text, query)) {
    raise(PyExc_ValueError, keyword_of(field) + " " + text + ": " + *wrong + ".");
  }
}

// Returns the request and the coloring of its surface.
std::pair<IsosurfaceRequest, std::optional<ScalarRequest>> surface_request(
    double isovalue, const std::shared_ptr<ThresholdGrid>& threshold_grid,
    const py::dict& keywords) {
  SurfaceQuery query{.isovalues = {isovalue}};
  query.request.thresholds.grid = threshold_grid;
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    const auto fields = request_fields();
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const RequestField& f) {
      return is_keyword(f) && keyword_of(f) == name;
    });
    if (field == fields.end()) raise(PyExc_TypeError, "A request has no keyword \"" + name + "\".");
    if (value.is_none()) continue;
    if (!field->is_repeatable) set(*field, value, query);
    if (field->is_repeatable) {
      for (const py::handle each : value) set(*field, each, query);
    }
  }
  return {argument(requests_for(query, DatasetInfo{})).front(), argument(scalars_for(query))};
}

// Raises ValueError if the values of one dataset cannot color surfaces of the other.
void check_same_world_or_raise(const ScalarRequest& scalars, const DatasetInfo& surface,
                               const DatasetInfo& values) {
  argument(check_same_world(scalars, surface, values));
}

// Lists each keyword with its name, the form of its value, its default as text and its meaning.
py::list request_keywords() {
  py::list keywords;
  for (const RequestField& field : request_fields()) {
    if (!is_keyword(field)) continue;
    keywords.append(
        py::make_tuple(keyword_of(field), field.value_syntax, field.default_text, field.help));
  }
  return keywords;
}

std::shared_ptr<ThresholdGrid> grid_of(
    const py::array_t<float, py::array::f_style | py::array::forcecast>& thresholds,
    const Vec3& spacing, const Vec3& origin) {
  if (thresholds.ndim() != 3) raise(PyExc_ValueError, "A grid of errors must have three axes.");
  auto grid = std::make_shared<ThresholdGrid>();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid->dims[axis] = static_cast<std::int32_t>(thresholds.shape(static_cast<py::ssize_t>(axis)));
    grid->index_to_world.columns[axis] = {0, 0, 0};
    grid->index_to_world.columns[axis][axis] = spacing[axis];
  }
  grid->index_to_world.translation = origin;
  grid->thresholds.assign(thresholds.data(), thresholds.data() + thresholds.size());
  return grid;
}

}  // namespace

void define_requests(py::module_& module) {
  py::class_<ThresholdGrid, std::shared_ptr<ThresholdGrid>>(module, "ThresholdGrid");
  py::class_<IsosurfaceRequest>(module, "IsosurfaceRequest");
  py::class_<ScalarRequest>(module, "ScalarRequest");
  module.def("surface_request", &surface_request);
  module.def("request_keywords", &request_keywords);
  module.def("check_same_world", &check_same_world_or_raise);
  module.def("grid", &grid_of, "thresholds"_a, "spacing"_a = Vec3{1, 1, 1},
             "origin"_a = Vec3{0, 0, 0},
             "Errors at the samples of an array (x, y, z), each for the voxel around it; NaN: no "
             "error is given there.");
}

}  // namespace multitetra
