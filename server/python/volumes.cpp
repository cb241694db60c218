#include "server/python/volumes.hpp"

#include <pybind11/stl.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/python/meshes.hpp"
#include "common/python/raise.hpp"
#include "common/request/lattice_limit.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/shared_budget.hpp"
#include "server/dataset/prepare.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/python/engine_definitions.hpp"
#include "server/python/engine_errors.hpp"
#include "server/python/interruptible.hpp"
#include "server/python/sources.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/service/surface_steps.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {

PythonVolume::PythonVolume(DatasetPtr opened)
    : dataset(std::move(opened)),
      surfaces(std::make_shared<const CachingSurfaceProvider>(
          std::make_shared<const SurfaceExtractor>(dataset))) {}

PrepareOptions options_for(const PythonSource& source, const PythonCall& call,
                           OperationState& state) {
  constexpr std::size_t kShortSlab = std::size_t{8} << 20;  // Stops within a tenth of a second.
  return {.name = source.name,
          .outside = call.pad_value,
          .margin = call.pad,
          .stop = state.stop(),
          .slab_bytes = kShortSlab,
          .progress = [&state](const char* pass, std::uint64_t done, std::uint64_t all) {
            throw_if_stopped(state.stop());
            state.report(pass, static_cast<double>(done) / static_cast<double>(all));
          }};
}

namespace {

PythonVolume load(const PythonSource& source, const PythonCall& call) {
  DatasetPtr dataset;
  run_interruptibly(call.threads, call.progress, [&](OperationState& state) {
    state.report("open", 0);
    const auto samples = source.open();
    dataset = prepare_in_memory(*samples, options_for(source, call, state));
  });
  return PythonVolume(std::move(dataset));
}

void prepare_file(const PythonSource& source, const std::string& output, bool samples_only,
                  const PythonCall& call) {
  run_interruptibly(call.threads, call.progress, [&](OperationState& state) {
    state.report("open", 0);
    const auto samples = source.open();
    PrepareOptions options = options_for(source, call, state);
    options.samples_only = samples_only;
    (void)prepare(*samples, options, output, source.provenance());
  });
}

// Writes the samples of a volume in memory.
void write(const PythonVolume& volume, const std::string& output) {
  run_interruptibly(0, py::none(), [&](OperationState&) {
    write_samples(*volume.dataset, output, {.file = volume.info().name, .digest = {}});
  });
}

PythonVolume open(const std::string& place) {
  DatasetPtr dataset;
  run_interruptibly(0, py::none(), [&](OperationState&) { dataset = open_dataset(place); });
  return PythonVolume(std::move(dataset));
}

// ---- surfaces

struct CheckedSurface {
  Surface surface = {};
  MeshTopology topology = {};
  WorldVertices vertices = {};
  bool is_final = true;
};

// Checks the surface as clients do.
CheckedSurface checked(CountedSurface counted, const PreparedVolume& volume) {
  if (!counted.topology.is_sound()) {
    throw std::runtime_error("The mesh has open, non-manifold or degenerate parts; this is a bug.");
  }
  CheckedSurface made{.surface = std::move(counted.surface), .topology = counted.topology};
  LatticeMesh& mesh = made.surface.mesh;
  made.vertices = world_vertices(mesh, grid_to_world(volume.info));
  mesh.normals =
      rounded_normals(volume, mesh, made.surface.request.normal_bits, NormalSource::kSamples);
  return made;
}

SurfaceFacts facts_of(const CheckedSurface& made, const DatasetInfo& info) {
  const Surface& surface = made.surface;
  const IsosurfaceRequest& request = surface.request;
  SurfaceFacts facts{
      .length_unit = info.meaning.length_unit,
      .space = std::string(name(info.meaning.space)),
      .topology = made.topology,
      .digest = surface.digest,
      .preserves_topology = request.topology_tolerance == 0 && surface.finest_spacing == 1,
      .is_intersection_free = request.simplify && request.intersection_free && made.is_final};
  if (facts.preserves_topology && request.error_measure == ErrorMeasure::kCertified) {
    facts.is_full_resolution = surface.error_bound_world == 0;
    facts.error_bound =
        surface.error_bound_world + lattice_rounding_world(info, request.lattice_resolution);
  }
  return facts;
}

// Returns the mesh, the reason why it is empty (empty text: it is not), the spacing of a preview,
// and whether it is the final one.
py::tuple python_step(CheckedSurface made, const DatasetInfo& info) {
  const SurfaceFacts facts = facts_of(made, info);
  std::string empty_text;
  if (made.surface.mesh.triangles.empty()) {
    empty_text = empty_surface_text(made.surface.request, info);
  }
  return py::make_tuple(
      mesh_of(std::move(made.surface.mesh), std::move(made.vertices), grid_to_world(info), facts),
      empty_text, made.surface.finest_spacing, made.is_final);
}

py::tuple isosurface(const PythonVolume& volume, const IsosurfaceRequest& request, int threads,
                     const py::object& progress) {
  argument(check_lattice(request, volume.info()));
  std::optional<Result<CheckedSurface>> made;
  run_interruptibly(threads, progress, [&](OperationState& state) {
    state.report("surface", 0);
    Result<CountedSurface> surface = final_surface(volume.surfaces, request, state.stop());
    if (!surface) {
      made = tl::unexpected(surface.error());
      return;
    }
    state.report("checks", 0);
    made = checked(*std::move(surface), *volume.dataset);
    state.report("checks", 1);
  });
  return python_step(value_or_raise(*std::move(made)), volume.info());
}

class PythonSteps {
 public:
  PythonSteps(const PythonVolume& volume, const IsosurfaceRequest& request, int threads)
      : volume_(volume),
        threads_(threads),
        steps_(volume.surfaces, request, StepPolicy::kProgressive) {
    argument(check_lattice(request, volume.info()));
  }

  // Returns None after the final step.
  py::object next(const py::object& progress) {
    std::optional<Result<std::optional<CheckedSurface>>> made;
    run_interruptibly(threads_, progress, [&](OperationState& state) {
      state.report("surface", 0);
      auto step = steps_.next(state.stop());
      if (!step) {
        made = tl::unexpected(step.error());
      } else if (!*step) {
        made.emplace(std::nullopt);
      } else {
        CheckedSurface surface = checked(std::move((*step)->counted), *volume_.dataset);
        surface.is_final = (*step)->is_final;
        made.emplace(std::move(surface));
      }
    });
    auto step = value_or_raise(*std::move(made));
    if (!step) return py::none();
    return python_step(*std::move(step), volume_.info());
  }

 private:
  PythonVolume volume_;
  int threads_;
  SurfaceSteps steps_;
};

EstimatedAnswer estimated(const PythonVolume& volume, const IsosurfaceRequest& request) {
  std::optional<Result<EstimatedAnswer>> made;
  run_interruptibly(0, py::none(), [&](OperationState& state) {
    made = estimate(*volume.surfaces, request, state.stop());
  });
  return value_or_raise(*std::move(made));
}

// Returns triangles and encoded bytes.
py::tuple size_of_surface(const PythonVolume& volume, const IsosurfaceRequest& request) {
  const SurfaceSize size = estimated(volume, request).size;
  return py::make_tuple(std::llround(size.triangles), std::llround(size.bytes));
}

std::vector<IsosurfaceRequest> with_shared_budget(const PythonVolume& volume,
                                                  std::vector<IsosurfaceRequest> requests) {
  argument(check_shared_budget(requests));
  if (!needs_shared_budget(requests)) return requests;
  std::vector<EstimatedSize> sizes;
  for (IsosurfaceRequest alone : requests) {
    alone.max_triangles = alone.max_bytes = 0;
    const SurfaceSize size = estimated(volume, alone).size;
    sizes.push_back({.triangles = static_cast<std::uint64_t>(std::llround(size.triangles)),
                     .bytes = static_cast<std::uint64_t>(std::llround(size.bytes))});
  }
  share_budget(requests, sizes);
  return requests;
}

}  // namespace

void define_volumes(py::module_& module) {
  py::class_<PythonCall>(module, "Call")
      .def(py::init(
          [](std::optional<double> pad_value, std::int32_t pad, int threads, py::object progress) {
            if (threads < 0) raise(PyExc_ValueError, "threads must be 0 (all) or greater.");
            return PythonCall{pad_value, pad, threads, std::move(progress)};
          }));
  module.def("load", &load);
  module.def("prepare", &prepare_file);
  module.def("open", &open);
  module.def("write", &write);
  py::class_<PythonVolume>(module, "Volume")
      .def_property_readonly("info", &PythonVolume::info,
                             py::return_value_policy::reference_internal)
      .def("isosurface", &isosurface)
      .def("steps",
           [](const PythonVolume& volume, const IsosurfaceRequest& request, int threads) {
             return std::make_unique<PythonSteps>(volume, request, threads);
           })
      .def("estimate", &size_of_surface)
      .def("share_budget", &with_shared_budget)
      .def("notices", [](const PythonVolume& volume, const IsosurfaceRequest& request) {
        return request_notices(request, volume.info());
      });
  py::class_<PythonSteps>(module, "Steps").def("next", &PythonSteps::next);
}

}  // namespace multitetra
