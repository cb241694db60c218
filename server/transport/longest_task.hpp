// Measures the tasks of a thread: the longest one delays everything else that the thread serves.
#pragma once

#include <ctime>

#include <algorithm>

namespace multitetra {

// Counts the thread's own CPU time, so that other load on the machine has no influence.
class LongestTask {
 public:
  LongestTask() : last_(cpu_seconds()) {}

  // Call after each task, on the same thread.
  void task_ended() {
    const double now = cpu_seconds();
    seconds_ = std::max(seconds_, now - last_);
    last_ = now;
  }
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  static double cpu_seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double last_;
  double seconds_ = 0;
};

}  // namespace multitetra
