// The threads behind core's ForEach: oneTBB.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>

namespace multitetra {

// Thrown out of long work whose stop token was triggered.
struct Cancelled {};

inline void throw_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Cancelled{};
}

// Calls body(0) ... body(count - 1) on all threads that oneTBB may use here, and returns when all
// have returned. Between two of them it looks at `stop` and throws Cancelled when it was triggered.
// Never runs work of other calls meanwhile, so the caller may hold a lock.
void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop = {});

// The number of those threads.
[[nodiscard]] std::size_t parallel_threads();

}  // namespace multitetra
