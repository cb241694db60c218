#include "client/python/errors.hpp"

#include <string>

namespace py = pybind11;

namespace multitetra {
namespace {

// Exception classes, which live as long as the interpreter.
PyObject* server_error = nullptr;
PyObject* check_error = nullptr;

PyObject* exception_class(py::module_& module, const char* name, const char* what) {
  const std::string full = std::string("multitetra.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), what, nullptr, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

}  // namespace

void raise(const ClientError& failure) {
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();  // KeyboardInterrupt.
  const auto& [code, text, retry_after] = failure.error;
  if (failure.source == ErrorSource::kCheck) raise(check_error, text);
  if (failure.source == ErrorSource::kNetwork) raise(PyExc_ConnectionError, text);
  const std::string code_name(name(code));
  py::object error = py::handle(server_error)(text + " (" + code_name + ")");
  error.attr("code") = code_name;
  error.attr("retry_after") = retry_after;
  PyErr_SetObject(server_error, error.ptr());
  throw py::error_already_set();
}

void define_errors(py::module_& module) {
  server_error =
      exception_class(module, "ServerError",
                      "The server rejected the request; `code` is the name of its ErrorCode.");
  check_error = exception_class(module, "CheckError",
                                "A reply is inconsistent or does not match the request.");
}

}  // namespace multitetra
