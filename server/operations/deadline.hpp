// A point in time that is polled.
#pragma once

#include <chrono>

namespace multitetra {

using Clock = std::chrono::steady_clock;

class Deadline {  // Initially none.
 public:
  void set(Clock::duration from_now) { at_ = Clock::now() + from_now; }
  void clear() { at_ = Clock::time_point::max(); }
  [[nodiscard]] bool is_past(Clock::time_point now) const { return now >= at_; }

 private:
  Clock::time_point at_ = Clock::time_point::max();
};

}  // namespace multitetra
