// The Python module multitetra._engine: surfaces in the process of the interpreter, without a
// server. The package's Python files have the public API and its documentation.
#include "common/sandbox/sandbox.hpp"
#include "server/python/engine_definitions.hpp"
#include "server/python/engine_errors.hpp"

PYBIND11_MODULE(_engine, module) {
  using namespace multitetra;
  pybind11::module_::import("multitetra._client");  // Has the types of requests and datasets.
  define_engine_errors(module);
  define_sources(module);
  define_volumes(module);
  define_certificates(module);
  define_parts(module);
  module.def("use_sandbox_program", &use_sandbox_program);
}
