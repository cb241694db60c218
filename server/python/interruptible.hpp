// Runs long operations without the GIL, so that Ctrl-C ends them and they report their progress.
//
//   run_interruptibly(threads, progress, [&](OperationState& state) {
//     state.report("surface", 0);
//     surface = final_surface(source, request, state.stop());
//   });
#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

namespace multitetra {

struct OperationProgress {
  std::string stage;
  double fraction = 0;  // Of the stage, 0 to 1.
};

// State that an operation and its caller share. Thread-safe.
class OperationState {
 public:
  // ---- for the operation
  [[nodiscard]] std::stop_token stop() const { return stop_.get_token(); }
  void report(const std::string& stage, double fraction);

  // ---- for its caller
  void request_stop() { stop_.request_stop(); }
  void set_done();
  // Waits for the end, for a short time. Returns whether it is reached.
  [[nodiscard]] bool wait();
  // Returns the last report unless it was returned before.
  [[nodiscard]] std::optional<OperationProgress> take_progress();

 private:
  std::stop_source stop_;
  std::mutex mutex_;  // Guards the members below.
  std::condition_variable changed_;
  bool is_done_ = false;
  std::optional<OperationProgress> progress_;
};

// Calls `work` in a thread of its own and returns when it has ended. Meanwhile calls
// `progress(stage, fraction)`, unless it is None, in this thread. A signal handler or a progress
// function that raises stops the work, and its exception is raised; otherwise that of the work.
// Requires the GIL. `threads` limits the threads of this process's work meanwhile; 0: no limit.
void run_interruptibly(int threads, const pybind11::object& progress,
                       const std::function<void(OperationState&)>& work);

}  // namespace multitetra
