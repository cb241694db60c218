#include "server/python/engine_errors.hpp"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <system_error>

#include "common/base/text.hpp"
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
    PyErr_SetString(volume_error, with_keywords(problem.what()).c_str());
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

std::string with_keywords(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; };
  std::string result;
  while (!text.empty()) {
    const bool is_option = text.starts_with("--") && text.size() > 2 && is_letter(text[2]) &&
                           (result.empty() || result.back() == ' ');
    if (!is_option) {
      result += text.front();
      text.remove_prefix(1);
      continue;
    }
    text.remove_prefix(2);
    const auto end = std::find_if_not(text.begin(), text.end(), is_letter);
    std::string name(text.begin(), end);
    std::replace(name.begin(), name.end(), '-', '_');
    text.remove_prefix(name.size());
    result += name == "length_unit" ? "unit" : name;
    const bool has_value = text.size() > 1 && text[0] == ' ' &&
                           (is_digit(text[1]) || (text[1] == '-' && text.size() > 2));
    if (!has_value) continue;
    result += '=';
    text.remove_prefix(1);
  }
  return result;
}

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
