#include "common/net/async_event.hpp"

#include "common/net/coroutines.hpp"

namespace multitetra {

void AsyncEvent::notify_all() {
  for (asio::steady_timer* const waiter : waiters_) waiter->cancel();
}

asio::awaitable<void> AsyncEvent::wait_until(Clock::time_point time) {
  asio::steady_timer timer(executor_, time);
  waiters_.push_back(&timer);
  co_await wait_on(timer);
  std::erase(waiters_, &timer);
}

}  // namespace multitetra
