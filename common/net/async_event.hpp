// Wakes coroutines that wait for a condition. Past notifications are not remembered: a coroutine
// checks its condition before waiting and again after waking up.
//
//   while (queue.empty()) co_await changed.wait();      // One coroutine, or several.
//   queue.push(x);  changed.notify_all();               // Another one.
//
// Single-threaded. The event must outlive all waiting coroutines.
#pragma once

#include <chrono>
#include <utility>
#include <vector>

#include "common/net/net.hpp"

namespace multitetra {

class AsyncEvent {
 public:
  using Clock = std::chrono::steady_clock;

  explicit AsyncEvent(asio::any_io_executor executor) : executor_(std::move(executor)) {}
  AsyncEvent(const AsyncEvent&) = delete;
  AsyncEvent& operator=(const AsyncEvent&) = delete;

  void notify_all();

  [[nodiscard]] asio::awaitable<void> wait() { return wait_until(Clock::time_point::max()); }
  // Waits until the next notification, or until `time`.
  [[nodiscard]] asio::awaitable<void> wait_until(Clock::time_point time);

 private:
  asio::any_io_executor executor_;
  std::vector<asio::steady_timer*> waiters_;
};

}  // namespace multitetra
