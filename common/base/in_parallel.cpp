#include "common/base/in_parallel.hpp"

#include <sched.h>

#include <algorithm>
#include <future>

#include "common/base/on_threads.hpp"

#if !defined(__SANITIZE_THREAD__)
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace multitetra {

#if defined(__SANITIZE_THREAD__)

// The thread sanitizer cannot see the synchronization inside the distribution's oneTBB and reports
// false races. Under it the work runs on plain threads, so every reported race is real.
void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop) {
  on_threads(2, count, [&](std::size_t i) {
    if (stop.stop_requested()) throw Cancelled{};
    body(i);
  });
}

std::size_t parallel_threads() { return 2; }

struct ThreadLimit::Control {};
ThreadLimit::ThreadLimit(int /*threads*/) {}

#else

void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop) {
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (stop.stop_requested()) throw Cancelled{};
      body(i);
    });
  });
}

std::size_t parallel_threads() {
  return std::min(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
                  static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
}

struct ThreadLimit::Control : tbb::global_control {
  using tbb::global_control::global_control;
};
ThreadLimit::ThreadLimit(int threads) {
  if (threads == 0) return;
  control_ = std::make_unique<Control>(tbb::global_control::max_allowed_parallelism,
                                       static_cast<std::size_t>(threads));
}

#endif

ThreadLimit::~ThreadLimit() = default;

void in_idle_time(std::size_t count, const std::function<void(std::size_t)>& body) {
  // A thread cannot leave this policy without privileges, and the threads that it starts have it.
  std::async(std::launch::async, [&] {
#ifdef SCHED_IDLE
    const sched_param any{};
    (void)::sched_setscheduler(0, SCHED_IDLE, &any);  // At worst it shares the processors.
#endif
    on_threads(parallel_threads(), count, body);
  }).get();
}

}  // namespace multitetra
