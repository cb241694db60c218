#include "server/python/engine_errors.hpp"

#include <exception>
#include <stdexcept>
#include <system_error>

#include "common/python/raise.hpp"
#include "common/sandbox/sandbox.hpp"
#include "server/core/spectrum/error_spectrum.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/store/store_error.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

PyObject* volume_error = nullptr;  // Lives as long as the interpreter.

void translate(std::exception_ptr thrown) {
  const auto unreadable = [](const std::exception& problem) {
    PyErr_SetString(volume_error, problem.what());
  };
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const VolumeFileError& problem) {
    unreadable(problem);
  } catch (const DatasetFileError& problem) {
    unreadable(problem);
  } catch (const DamagedSpectrumError& problem) {
    unreadable(problem);
  } catch (const StoreError& problem) {
    unreadable(problem);
  } catch (const std::system_error& problem) {
    PyErr_SetString(PyExc_OSError, problem.what());
  }
}

}  // namespace

void define_engine_errors(py::module_& module) {
  volume_error = PyErr_NewExceptionWithDoc("multitetra.VolumeError",
                                           "A volume or dataset cannot be read, or is damaged.",
                                           PyExc_ValueError, nullptr);
  if (volume_error == nullptr) throw py::error_already_set();
  module.attr("VolumeError") = py::handle(volume_error);
  py::register_local_exception_translator(&translate);
}

void raise(const Error& error) {
  const bool is_bad_request =
      error.code == ErrorCode::kInvalidArgument || error.code == ErrorCode::kLimitExceeded;
  raise(is_bad_request ? PyExc_ValueError : PyExc_RuntimeError, error.text);
}

}  // namespace multitetra
