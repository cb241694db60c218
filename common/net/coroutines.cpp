#include "common/net/coroutines.hpp"

#include <utility>

namespace multitetra {

void spawn(asio::any_io_executor executor, Coroutine coroutine,
           std::function<void(std::exception_ptr)> done) {
  asio::co_spawn(executor, std::move(coroutine),
                 [done = std::move(done)](const std::exception_ptr& failure) {
                   if (done) done(failure);
                 });
}

void post(asio::any_io_executor executor, std::function<void()> function) {
  asio::post(executor, std::move(function));
}

asio::awaitable<void> wait_on(asio::steady_timer& timer) {
  error_code cancelled;
  co_await timer.async_wait(use_error(cancelled));
}

void when_expired(asio::steady_timer& timer, std::function<void()> expired) {
  timer.async_wait([expired = std::move(expired)](const error_code& cancelled) {
    if (!cancelled) expired();
  });
}

}  // namespace multitetra
