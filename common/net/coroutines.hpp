// Coroutines and timers without templates: each use of Asio's own costs a second to compile.
#pragma once

#include <chrono>
#include <exception>
#include <functional>

#include "common/net/net.hpp"

namespace multitetra {

using Coroutine = std::function<asio::awaitable<void>()>;

// Runs a coroutine on the executor. `coroutine` is kept until it is over; then `done` is called
// with the exception that ended it, or null. Without `done` an exception is ignored.
void spawn(asio::any_io_executor executor, Coroutine coroutine,
           std::function<void(std::exception_ptr)> done = {});

// Calls the function on the executor's thread, never from inside this call.
void post(asio::any_io_executor executor, std::function<void()> function);

// Until then, or until the timer is cancelled.
[[nodiscard]] asio::awaitable<void> wait_on(asio::steady_timer& timer);

// `expired` is called unless the timer is cancelled or set again.
void when_expired(asio::steady_timer& timer, std::function<void()> expired);

}  // namespace multitetra
