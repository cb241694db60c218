// The Python module multitetra._client: the C++ client with Python and NumPy types. The package's
// Python files have the public API and its documentation.
#include "client/python/channel.hpp"
#include "client/python/definitions.hpp"
#include "client/python/errors.hpp"
#include "client/python/meshes.hpp"

PYBIND11_MODULE(_client, module) {
  using namespace multitetra;
  module.attr("__version__") = MULTITETRA_VERSION;
  define_errors(module);
  define_meshes(module);
  define_requests(module);
  define_datasets(module);
  define_answers(module);
  define_connection(module);
  define_channel(module);
}
