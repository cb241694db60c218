#include "common/base/in_parallel.hpp"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <vector>

#include "common/base/on_threads.hpp"
#include "common/base/yielding.hpp"

#if !defined(__SANITIZE_THREAD__)
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace multitetra {
namespace {

#if defined(__SANITIZE_THREAD__)

// The thread sanitizer cannot see the synchronization inside the distribution's oneTBB and reports
// false races. Under it the work runs on plain threads, so every reported race is real.
void for_each(std::size_t count, const std::function<void(std::size_t)>& body) {
  on_threads(2, count, body);
}

}  // namespace

std::size_t parallel_threads() { return 2; }

struct ThreadLimit::Control {};
ThreadLimit::ThreadLimit(int /*threads*/) {}

#else

void for_each(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, body); });
}

}  // namespace

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

void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop) {
  const YieldingLoop loop;
  std::vector<char> is_done(loop.may_yield() ? count : 0);
  for (std::atomic<bool> remain = true; remain.exchange(false);) {
    for_each(count, [&](std::size_t i) {
      if (loop.may_yield()) {
        if (is_done[i]) return;
        if (loop.is_due()) {
          remain = true;
          return;
        }
      }
      throw_if_stopped(stop);
      body(i);
      if (loop.may_yield()) is_done[i] = 1;
    });
    if (remain) loop.wait();
  }
}

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
