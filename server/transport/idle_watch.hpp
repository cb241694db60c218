// Notices who asks for nothing for a long time. One timer that is set anew only when it has run
// out, so that messages cost nothing.
//
//   IdleWatch idleness(executor, /*limit=*/600s);   // 0: nobody is too idle.
//   idleness.start(weak_from_this(), [](StreamSession& c) { ... });
//
// On one thread.
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include "common/net/net.hpp"

namespace multitetra {

class IdleWatch {
 public:
  using Clock = std::chrono::steady_clock;

  IdleWatch(asio::any_io_executor executor, std::chrono::milliseconds limit)
      : limit_(limit), timer_(executor) {}

  // The client has said something, or something was finished for it.
  void note() { last_ = Clock::now(); }
  void stop() { timer_.cancel(); }

  // Calls when_idle(owner) once, when nothing was noted for longer than the limit while
  // is_busy(owner) was false. Ends with the owner, of which this is a member.
  template <typename Owner, typename IsBusy, typename WhenIdle>
  void start(std::weak_ptr<Owner> owner, IsBusy is_busy, WhenIdle when_idle) {
    if (limit_.count() <= 0) return;
    timer_.expires_at(last_ + limit_);
    timer_.async_wait([this, owner = std::move(owner), is_busy,
                       when_idle](const boost::system::error_code& cancelled) {
      const auto self = owner.lock();
      if (cancelled || !self) return;
      if (is_busy(*self)) note();
      if (last_ + limit_ <= Clock::now()) {
        when_idle(*self);
      } else {
        start(owner, is_busy, when_idle);
      }
    });
  }

 private:
  std::chrono::milliseconds limit_;
  Clock::time_point last_ = Clock::now();
  asio::steady_timer timer_;
};

}  // namespace multitetra
