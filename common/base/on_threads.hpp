// Parallel loops on threads of their own, where oneTBB cannot be used.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace multitetra {

// Calls body(0) to body(count - 1) on this thread and up to `threads` - 1 others. After an
// exception it begins no further calls, and rethrows it.
template <typename Body>
void on_threads(std::size_t threads, std::size_t count, const Body& body) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;  // Guards `failure`.
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;  // Joined at the end of this block.
    for (std::size_t i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace multitetra
