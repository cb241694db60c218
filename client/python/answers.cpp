#include "client/python/definitions.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <bit>

#include "client/python/connection.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

template <typename Member>
auto of_begin(Member StepBegin::*member) {
  return [member](const FetchedSurface& step) { return step.committed->begin.*member; };
}

void define_estimates_and_samples(py::module_& module) {
  py::class_<EstimateReply>(module, "Estimate", "The estimated size of a surface.")
      .def_readonly("triangles", &EstimateReply::triangles)
      .def_readonly("bytes", &EstimateReply::bytes)
      .def_readonly("error_world", &EstimateReply::error_bound_world,
                    "The largest error that is allowed anywhere.");
  py::class_<SliceReply>(module, "SampledSlice")
      .def_readonly("sample_spacing", &SliceReply::sample_spacing,
                    "1, or 8 if every eighth sample was used.")
      .def_property_readonly(
          "values",
          [](const SliceReply& slice) {
            static_assert(std::endian::native == std::endian::little);
            return py::array(py::dtype::of<float>(), {slice.height, slice.width},
                             slice.values->data());
          },
          "(height, width) float32, NaN without a field.");
  py::class_<ProbedPlace>(module, "ProbedPlace")
      .def_property_readonly("world",
                             [](const ProbedPlace& p) { return py::array(py::cast(p.world)); })
      .def_property_readonly("index",
                             [](const ProbedPlace& p) { return py::array(py::cast(p.index)); })
      .def_readonly("value", &ProbedPlace::value, "None without a field.")
      .def_property_readonly(
          "gradient",
          [](const ProbedPlace& p) -> py::object {
            if (!p.gradient) return py::none();
            return py::array(py::cast(*p.gradient));
          },
          "(3,), by world unit; None without a field.");
}

}  // namespace

void define_answers(py::module_& module) {
  define_estimates_and_samples(module);
  py::class_<FetchedSurface>(module, "Step", "A complete surface that passed all checks.")
      .def_property_readonly("number", of_begin(&StepBegin::step))
      .def_property_readonly("is_final", of_begin(&StepBegin::is_final))
      .def_property_readonly("error_bound_world", of_begin(&StepBegin::error_bound_world),
                             "The bound of the distance to the full-resolution surface before the "
                             "rounding of vertices, "
                             "if spacing is 1; that of the mesh includes it.")
      .def_property_readonly("spacing", of_begin(&StepBegin::finest_spacing),
                             "1, or the sample spacing of a preview, which has no error bound.")
      .def_readonly("mesh", &FetchedSurface::mesh)
      .def_readonly("empty_text", &FetchedSurface::empty_text,
                    "The reason if the mesh has no triangles; otherwise empty.")
      .def_property_readonly(
          "digest", [](const FetchedSurface& step) { return step.committed->end.digest.hex(); },
          "The digest of all triangles, as in reports of multitetra-client.")
      .def_property_readonly(
          "border_edges",
          [](const FetchedSurface& step) { return step.committed->topology.border_edges; },
          "Edges with one triangle; all of them lie where the data ends.")
      .def_property_readonly(
          "euler_characteristic",
          [](const FetchedSurface& step) { return step.committed->topology.euler_characteristic; })
      .def_property_readonly(
          "components",
          [](const FetchedSurface& step) { return step.committed->topology.components; })
      .def_property_readonly(
          "preserves_topology",
          [](const FetchedSurface& step) { return preserves_topology(step.committed->begin); },
          "Whether the topology is that of the full-resolution surface.")
      .def_property_readonly(
          "tiles_received",
          [](const FetchedSurface& step) { return step.committed->end.tiles_sent; })
      .def_property_readonly(
          "payload_bytes",
          [](const FetchedSurface& step) { return step.committed->end.payload_bytes; })
      .def_property_readonly(
          "scalar_deviation",
          [](const FetchedSurface& step) { return step.committed->largest_scalar_deviation; },
          "Largest error of colors between vertices, in values of color_by.");
}

}  // namespace multitetra
