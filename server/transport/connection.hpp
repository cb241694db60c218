// One connection of a listener, whatever is spoken on it at the time.
#pragma once

#include <chrono>
#include <memory>

#include "common/base/result.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;

class Connection {
 public:
  virtual ~Connection() = default;

  // Tells why, where there are words for it, and ends; within the linger time the connection is
  // closed whatever the client does.
  virtual void end(const Error& why) = 0;
  // Ends what takes too long. Called again and again with the time that it is: so thousands of
  // connections share one timer instead of arming several each for every message.
  virtual void keep_time(Clock::time_point now) = 0;
};
using ConnectionPtr = std::shared_ptr<Connection>;

// A moment that is looked at by keep_time(); none at first.
class Deadline {
 public:
  void set(Clock::duration from_now) { at_ = Clock::now() + from_now; }
  void clear() { at_ = Clock::time_point::max(); }
  [[nodiscard]] bool is_past(Clock::time_point now) const { return now >= at_; }

 private:
  Clock::time_point at_ = Clock::time_point::max();
};

}  // namespace multitetra
