// Parallel loops on oneTBB, the implementation of core's ForEach.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>

namespace multitetra {

// Thrown by long operations after their stop token was triggered.
struct Cancelled {};

inline void throw_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Cancelled{};
}

// Calls body(0) ... body(count - 1) on all threads oneTBB may use here, and returns when all calls
// have returned. Checks `stop` before each call and throws Cancelled if it was triggered. Never
// runs unrelated work in the meantime, so the caller may hold a lock. Between calls it yields as
// yielding.hpp says.
void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop = {});

// The same, on threads of its own that run only while no others need their processors.
void in_idle_time(std::size_t count, const std::function<void(std::size_t)>& body);

// Returns the number of threads in_parallel() uses.
[[nodiscard]] std::size_t parallel_threads();

// Limits the threads of this process's parallel loops during its lifetime. 0: no limit.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

}  // namespace multitetra
