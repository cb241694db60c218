#include "server/python/interruptible.hpp"

#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "common/base/in_parallel.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

constexpr std::chrono::milliseconds kSignalInterval{30};

// Returns the exception that a signal handler or `progress` raised.
std::exception_ptr interruption(OperationState& state, const py::object& progress) {
  const py::gil_scoped_acquire held;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return nullptr;
    if (const auto report = state.take_progress()) progress(report->stage, report->fraction);
  } catch (const py::error_already_set&) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace

void OperationState::report(const std::string& stage, double fraction) {
  const std::lock_guard lock(mutex_);
  progress_ = {stage, fraction};
}

void OperationState::set_done() {
  const std::lock_guard lock(mutex_);
  is_done_ = true;
  changed_.notify_all();
}

bool OperationState::wait() {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kSignalInterval, [this] { return is_done_; });
}

std::optional<OperationProgress> OperationState::take_progress() {
  const std::lock_guard lock(mutex_);
  return std::exchange(progress_, std::nullopt);
}

void run_interruptibly(int threads, const py::object& progress,
                       const std::function<void(OperationState&)>& work) {
  OperationState state;
  std::exception_ptr failure;
  std::exception_ptr raised;
  {
    const py::gil_scoped_release released;
    std::thread worker([&] {
      try {
        const ThreadLimit limit(threads);
        work(state);
      } catch (...) {
        failure = std::current_exception();
      }
      state.set_done();
    });
    while (!state.wait()) {
      if (!raised) raised = interruption(state, progress);
      if (raised) state.request_stop();
    }
    worker.join();
  }
  if (!raised) raised = interruption(state, progress);
  if (raised) std::rethrow_exception(raised);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace multitetra
