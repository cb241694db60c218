// Preparation in parts for Python; client/python/multitetra/dask.py runs it on clusters.
#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <utility>

#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/partitioned/prepare_parts.hpp"
#include "server/python/engine_definitions.hpp"
#include "server/python/interruptible.hpp"
#include "server/python/sources.hpp"
#include "server/python/volumes.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

void plan_parts(const PythonSource& source, const std::string& output, std::size_t parts,
                const PythonCall& call) {
  run_interruptibly(call.threads, call.progress, [&](OperationState& state) {
    const auto samples = source.open();
    VolumeSurvey found = survey(*samples, options_for(source, call, state));
    write_plan(output, {.metadata = {.info = std::move(found.info),
                                     .source = source.provenance(),
                                     .program_version = MULTITETRA_VERSION},
                        .bins = std::move(found.bins),
                        .parts = parts});
  });
}

void make_part(const PythonSource& source, const std::string& output, std::size_t part,
               int threads) {
  run_interruptibly(threads, py::none(), [&](OperationState&) {
    const auto samples = source.open();
    prepare_part(*samples, output, part);
  });
}

void merge(const std::string& output) {
  run_interruptibly(0, py::none(), [&](OperationState&) { (void)merge_parts(output); });
}

}  // namespace

void define_parts(py::module_& module) {
  module.def("plan_parts", &plan_parts);
  module.def("prepare_part", &make_part);
  module.def("merge_parts", &merge);
}

}  // namespace multitetra
