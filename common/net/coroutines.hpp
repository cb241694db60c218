// Coroutines and timers without templates, as each use of Asio costs a second of compile time.
#pragma once

#include <chrono>
#include <exception>
#include <functional>

#include "common/net/net.hpp"

namespace multitetra {

using Coroutine = std::function<asio::awaitable<void>()>;

// Runs a coroutine on the executor. Keeps `coroutine` alive until it ends, then calls `done` with
// the exception that ended it, or null. Without `done`, exceptions are ignored.
void spawn(asio::any_io_executor executor, Coroutine coroutine,
           std::function<void(std::exception_ptr)> done = {});

// Calls the function on the executor's thread, never from inside this call.
void post(asio::any_io_executor executor, std::function<void()> function);

// Waits until the timer expires or is cancelled.
[[nodiscard]] asio::awaitable<void> wait_on(asio::steady_timer& timer);

// Calls `expired` unless the timer is cancelled or set again.
void when_expired(asio::steady_timer& timer, std::function<void()> expired);

}  // namespace multitetra
