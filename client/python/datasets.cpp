#include "client/python/definitions.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <string>
#include <vector>

#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/dataset/dataset_fields.hpp"
#include "common/python/arrays.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

// "<Dataset head: 256 x 256 x 124 u16, spacing 0.94 x 0.94 x 1.5 mm, values 0 to 2766>"
std::string text_of_dataset(const DatasetInfo& info) {
  const auto joined = [](const auto& numbers) {
    std::string text;
    for (const auto number : numbers) {
      text += (text.empty() ? "" : " x ") + rounded_text(static_cast<double>(number));
    }
    return text;
  };
  const auto with_unit = [](const std::string& unit) { return unit.empty() ? "" : " " + unit; };
  return "<Dataset " + info.name + ": " + joined(info.dims) + " " + std::string(name(info.type)) +
         ", spacing " + joined(info.spacing) + with_unit(info.meaning.length_unit) + ", values " +
         number_at(info.min, 1e-5 * (info.max - info.min)) + " to " +
         number_at(info.max, 1e-5 * (info.max - info.min)) + with_unit(info.meaning.value_unit) +
         ">";
}

double affine_entry(const Affine& map, py::ssize_t row, py::ssize_t column) {
  if (row == 3) return column == 3 ? 1 : 0;
  const auto r = static_cast<std::size_t>(row);
  return column == 3 ? map.translation[r] : map.columns[static_cast<std::size_t>(column)][r];
}

// The values of fields of DatasetInfo. Unknown texts are empty.
template <typename Value>
py::object python_value(const Value& value) {
  return py::cast(value);
}
py::object python_value(SampleType type) { return py::cast(name(type)); }
py::object python_value(WorldSpace space) { return py::cast(name(space)); }
py::object python_value(GeometryBasis basis) { return py::cast(name(basis)); }
// (4, 3): the steps along the axes, and the position of the first sample.
py::object python_value(const Affine& map) {
  const auto& [columns, translation] = map;
  return rows_of<double>(std::vector{columns[0], columns[1], columns[2], translation});
}
py::object python_value(const Histogram& histogram) {
  return py::make_tuple(histogram.low, histogram.high, histogram.counts);
}
py::object python_value(const std::optional<DisplayWindow>& window) {
  if (!window) return py::none();
  return py::make_tuple(window->low, window->high);
}

// Returns a text about a field as Python users read it.
std::string with_none(std::string text) {
  const std::size_t at = text.find("null:");
  return at == std::string::npos ? text : text.replace(at, 4, "None");
}

void define_members_of_series(py::module_& module) {
  py::class_<Label>(module, "Label")
      .def_readonly("value", &Label::value)
      .def_readonly("name", &Label::name)
      .def_readonly("color", &Label::color);
  py::class_<LabelExtent>(module, "LabelExtent")
      .def_readonly("samples", &LabelExtent::samples, "With the label's value in its label map.")
      .def_property_readonly(
          "box",
          [](const LabelExtent& extent) -> py::object {
            if (!extent.place) return py::none();
            return py::make_tuple(extent.place->least, extent.place->greatest);
          },
          "The smallest and the largest index of these samples; None: unknown.")
      .def_property_readonly(
          "centroid",
          [](const LabelExtent& extent) -> py::object {
            return extent.place ? py::cast(extent.place->centroid) : py::none();
          },
          "Their mean index; None: unknown.");
  py::class_<SeriesMember>(module, "SeriesMember")
      .def_readonly("series", &SeriesMember::series)
      .def_readonly("field", &SeriesMember::field)
      .def_readonly("time", &SeriesMember::time)
      .def_readonly("time_unit", &SeriesMember::time_unit)
      .def_readonly("color", &SeriesMember::color, "0xRRGGBB of the field; None: unknown.")
      .def_readonly("label", &SeriesMember::label);
}

}  // namespace

void define_datasets(py::module_& module) {
  define_members_of_series(module);
  py::class_<DatasetInfo> type(module, "DatasetInfo");
#define MULTITETRA_DEFINE(key, member, help)                                   \
  type.def_property_readonly(                                                  \
      #key, [](const DatasetInfo& info) { return python_value(info.member); }, \
      with_none(help).c_str());
  MULTITETRA_DATASET_FIELDS(MULTITETRA_DEFINE)
#undef MULTITETRA_DEFINE
  type.def_readonly("label_extent", &DatasetInfo::label_extent)
      .def("__repr__", &text_of_dataset)
      .def_property_readonly(
          "shape",
          [](const DatasetInfo& info) {
            return py::make_tuple(info.dims[0], info.dims[1], info.dims[2]);
          },
          "Samples along x, y and z.")
      .def_property_readonly(
          "affine",
          [](const DatasetInfo& info) {
            py::array_t<double> affine({4, 4});
            auto at = affine.mutable_unchecked<2>();
            for (py::ssize_t row = 0; row < 4; ++row) {
              for (py::ssize_t column = 0; column < 4; ++column) {
                at(row, column) = affine_entry(info.index_to_world, row, column);
              }
            }
            return affine;
          },
          "(4, 4): the world coordinates of a sample are affine @ [x, y, z, 1].")
      .def_property_readonly(
          "unit", [](const DatasetInfo& info) { return info.meaning.length_unit; },
          "The unit of spacing and world coordinates; empty if unknown.");
}

}  // namespace multitetra
