// Comparison of meshes with volumes for Python.
#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "common/python/arrays.hpp"
#include "common/python/raise.hpp"
#include "server/certify/certificate_report.hpp"
#include "server/certify/mesh_file.hpp"
#include "server/python/engine_definitions.hpp"
#include "server/python/interruptible.hpp"
#include "server/python/volumes.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

TriangleMesh mesh_of_arrays(const Rows<double>& vertices, const Rows<std::int64_t>& faces,
                            std::optional<int> lattice) {
  TriangleMesh mesh{
      .vertices = rows_from(vertices, "Vertices"), .triangles = {}, .lattice = lattice};
  for (const Vec3& vertex : mesh.vertices) {
    if (!(std::isfinite(vertex[0]) && std::isfinite(vertex[1]) && std::isfinite(vertex[2]))) {
      raise(PyExc_ValueError, "A vertex has a coordinate that is not finite.");
    }
  }
  const auto count = static_cast<std::int64_t>(mesh.vertices.size());
  for (const auto& face : rows_from(faces, "Faces")) {
    for (const std::int64_t corner : face) {
      if (corner >= 0 && corner < count) continue;
      raise(PyExc_ValueError, "A face refers to vertex " + std::to_string(corner) +
                                  ", but the number of vertices is " + std::to_string(count) + ".");
    }
    mesh.triangles.push_back({static_cast<std::uint32_t>(face[0]),
                              static_cast<std::uint32_t>(face[1]),
                              static_cast<std::uint32_t>(face[2])});
  }
  return mesh;
}

TriangleMesh mesh_of_file(const std::string& file) {
  TriangleMesh mesh;
  run_interruptibly(0, py::none(), [&](OperationState&) { mesh = read_mesh(file); });
  return mesh;
}

struct CertifyCall {
  double isovalue = 0;
  std::optional<double> error;  // In voxels, or world units.
  bool is_in_voxels = true;
  CertifyOptions options;
  std::optional<double> min_component;
};

CertifyOptions options_of(const CertifyCall& call, const TriangleMesh& mesh,
                          const DatasetInfo& info) {
  CertifyOptions options = call.options;
  options.isovalue = call.isovalue;
  if (!options.lattice) options.lattice = mesh.lattice;
  options.min_component = call.min_component.value_or(mesh.min_component);
  if (call.error) options.error = *call.error * (call.is_in_voxels ? voxel_length(info) : 1.0);
  options.outside = info.outside;
  options.margin = info.margin;
  options.try_maps = true;
  return options;
}

// Returns the JSON report and the text of `multitetra-server certify`.
py::tuple certified(TriangleMesh& mesh, const std::string& name, const PythonVolume& volume,
                    const CertifyCall& call, int threads, const py::object& progress) {
  const DatasetInfo& info = volume.info();
  CertifyOptions options = options_of(call, mesh, info);
  std::string report;
  std::string text;
  run_interruptibly(threads, progress, [&](OperationState& state) {
    options.stop = state.stop();
    options.on_stage = [&](const char* stage) { state.report(stage, 0); };
    Volume whole = whole_volume(*volume.dataset);
    whole.meaning = info.meaning;
    const CertifiedFiles files{.mesh = name,
                               .volume = info.name,
                               .mesh_notices = convert_to_unit(mesh, info.meaning.length_unit)};
    const Certificate certificate = certify(mesh, whole, options);
    report = text_of(json_of(certificate, files, options));
    text = text_of(certificate, files, options);
  });
  return py::make_tuple(report, text);
}

}  // namespace

void define_certificates(py::module_& module) {
  py::class_<TriangleMesh>(module, "TriangleMesh");
  module.def("mesh_of_arrays", &mesh_of_arrays);
  module.def("mesh_of_file", &mesh_of_file);
  py::class_<CertifyCall>(module, "CertifyCall")
      .def(
          py::init([](double isovalue, std::optional<double> error, bool is_in_voxels,
                      bool any_topology, bool self_intersections, bool inside_out,
                      bool allow_rounding, std::optional<double> min_component,
                      std::optional<int> lattice) {
            if (lattice && (*lattice < kMinLatticeResolution || *lattice > kMaxLatticeResolution)) {
              raise(PyExc_ValueError, "lattice is " + std::to_string(*lattice) +
                                          "; it must be from " +
                                          std::to_string(kMinLatticeResolution) + " to " +
                                          std::to_string(kMaxLatticeResolution) + ".");
            }
            return CertifyCall{.isovalue = isovalue,
                               .error = error,
                               .is_in_voxels = is_in_voxels,
                               .options = {.lattice = lattice,
                                           .any_topology = any_topology,
                                           .count_self_intersections = self_intersections,
                                           .allow_rounding = allow_rounding,
                                           .is_inside_out = inside_out},
                               .min_component = min_component};
          }),
          "isovalue"_a, "error"_a, "is_in_voxels"_a, "any_topology"_a, "self_intersections"_a,
          "inside_out"_a, "allow_rounding"_a, "min_component"_a, "lattice"_a);
  module.def("certify", &certified);
}

}  // namespace multitetra
