#include "server/python/sources.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/dataset/length_units.hpp"
#include "common/python/raise.hpp"
#include "server/python/engine_definitions.hpp"
#include "server/python/engine_errors.hpp"
#include "server/store/http_options.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/volume_files.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

// The slices of an array-like object of Python.
// Calls `fill(first, end, into)` for slices first to end - 1: it copies them to the array `into` of
// shape (end - first, height, width) and raises what prevents it. Each call takes the GIL.
class ArraySlices final : public StoredSlices {
 public:
  // `shape` is (depth, height, width).
  ArraySlices(pybind11::function fill, const std::array<std::int64_t, 3>& shape, StoredType type);
  ~ArraySlices() override {
    const py::gil_scoped_acquire held;
    fill_ = py::function();
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const py::gil_scoped_acquire held;
    const py::dtype type =
        with_number_type(type_, []<typename Number>() { return py::dtype::of<Number>(); });
    const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(count), shape_[1], shape_[2]};
    const py::array view(type, shape, into, py::none());  // None owns it, so it is no copy.
    fill_(first, first + count, view);
  }

 private:
  pybind11::function fill_;
  std::array<std::int64_t, 3> shape_;
  StoredType type_;
};

ArraySlices::ArraySlices(py::function fill, const std::array<std::int64_t, 3>& shape,
                         StoredType type)
    : fill_(std::move(fill)), shape_(shape), type_(type) {}

using StoredSlicesPtr = std::unique_ptr<StoredSlices>;
using Notify = std::function<void(const std::string&)>;

Notify to(const std::shared_ptr<NoticeList>& notices) {
  return [notices](const std::string& text) { notices->add(text); };
}

// `shape` is that of the slices, `steps` the world steps along its axes.
std::unique_ptr<PythonSource> array_source(const std::string& name, py::function fill,
                                           const std::array<std::int64_t, 3>& shape,
                                           const std::string& type,
                                           const std::array<Vec3, 3>& steps, const Vec3& origin,
                                           const std::string& space, const std::string& unit,
                                           const std::string& value_unit, double subtract,
                                           bool allow_loss) {
  const auto stored = stored_type_from(type);
  if (!stored) raise(PyExc_TypeError, "Samples of type " + type + " are no numbers.");
  for (const std::string& text : {unit, value_unit}) {
    if (!is_unit_text(text)) {
      raise(PyExc_ValueError, "A unit has at most " + std::to_string(kMaxUnitBytes) +
                                  " bytes of UTF-8 without control characters.");
    }
  }
  ImageHeader header{
      .dims = {shape[2], shape[1], shape[0]}, .type = *stored, .values = kNumbersAsStored};
  header.meaning = {.space = world_space_from(space).value_or(WorldSpace::kUnnamed),
                    .length_unit = unit,
                    .value_unit = value_unit};
  set_axes(header, {steps[2], steps[1], steps[0]}, stated(origin));
  const auto notices = std::make_shared<NoticeList>();
  const auto slices = std::make_shared<StoredSlicesPtr>(
      std::make_unique<ArraySlices>(std::move(fill), shape, *stored));
  return std::make_unique<PythonSource>(PythonSource{
      .open =
          [=] {
            return volume_of_slices(name, {.header = header, .slices = std::move(*slices)},
                                    {.choice = {.subtract = subtract, .allow_loss = allow_loss},
                                     .notice = to(notices)});
          },
      .provenance = [=] { return Provenance{.file = name, .digest = {}}; },
      .name = name,
      .notices = notices});
}

template <typename Parsed>
Parsed parsed(std::optional<Parsed> value, const std::string& option, const std::string& text) {
  if (!value) raise(PyExc_ValueError, option + ": \"" + text + "\" is invalid.");
  return *std::move(value);
}

template <typename Value>
Value as(const py::dict& options, const char* name) {
  try {
    return options[name].cast<Value>();
  } catch (const py::cast_error&) {
    raise(PyExc_TypeError, std::string(name) + " is " +
                               py::repr(options[name]).cast<std::string>() +
                               ", which is not of the right type.");
  }
}

VolumeChoice choice_from(const py::dict& options) {
  VolumeChoice choice;
  const auto take = [&](const char* name, auto& into) {
    if (options.contains(name)) into = as<std::decay_t<decltype(into)>>(options, name);
  };
  take("array", choice.array);
  take("level", choice.level);
  take("time", choice.time);
  take("channel", choice.channel);
  take("series", choice.series);
  take("resample", choice.resample);
  take("subtract", choice.subtract);
  take("allow_loss", choice.allow_loss);
  if (options.contains("component")) {
    const auto text = py::str(options["component"]).cast<std::string>();
    choice.component = parsed(ComponentChoice::from(text), "component", text);
  }
  return choice;
}

Placement placement_from(const py::dict& options) {
  Placement placement;
  if (options.contains("spacing")) placement.spacing = options["spacing"].cast<Vec3>();
  if (options.contains("origin")) placement.origin = options["origin"].cast<Vec3>();
  if (options.contains("unit")) {
    placement.length_unit = as<std::string>(options, "unit");
    if (!is_unit_text(*placement.length_unit)) {
      raise(PyExc_ValueError, "unit is no unit: it has control characters, or more than " +
                                  std::to_string(kMaxUnitBytes) + " bytes.");
    }
  }
  if (options.contains("orient")) {
    const auto text = as<std::string>(options, "orient");
    placement.orient = parsed(axis_directions_from(text), "orient", text);
  }
  if (options.contains("space")) {
    const auto text = as<std::string>(options, "space");
    placement.space = parsed(world_space_from(text), "space", text);
  }
  return placement;
}

std::unique_ptr<PythonSource> file_source(const std::string& path, const std::string& name,
                                          const py::dict& options) {
  const auto notices = std::make_shared<NoticeList>();
  const VolumeFileOptions how = {
      .choice = choice_from(options), .placement = placement_from(options), .notice = to(notices)};
  return std::make_unique<PythonSource>(PythonSource{
      .open = [=] { return open_volume(path, how); },
      .provenance =
          [=] {
            return is_address(path) ? Provenance{.file = without_password(path), .digest = {}}
                                    : provenance(path);
          },
      .name = name.empty() ? default_dataset_name(path) : name,
      .notices = notices});
}

}  // namespace

void define_sources(py::module_& module) {
  py::class_<PythonSource>(module, "Source")
      .def_property_readonly("notices", [](const PythonSource& source) {
        std::vector<std::string> texts = source.notices->texts();
        for (std::string& text : texts) text = with_keywords(text);
        return texts;
      });
  module.def("length_factor", [](const std::string& unit, const std::string& other) {
    return length_factor(unit, other);
  });
  module.def("array_source", &array_source, "name"_a, "fill"_a, "shape"_a, "type"_a, "steps"_a,
             "origin"_a, "space"_a, "unit"_a, "value_unit"_a, "subtract"_a, "allow_loss"_a);
  module.def("file_source", &file_source, "path"_a, "name"_a, "options"_a);
}

}  // namespace multitetra
