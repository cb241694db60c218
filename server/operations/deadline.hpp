// A moment that is looked at again and again.
#pragma once

#include <chrono>

namespace multitetra {

using Clock = std::chrono::steady_clock;

class Deadline {  // None at first.
 public:
  void set(Clock::duration from_now) { at_ = Clock::now() + from_now; }
  void clear() { at_ = Clock::time_point::max(); }
  [[nodiscard]] bool is_past(Clock::time_point now) const { return now >= at_; }

 private:
  Clock::time_point at_ = Clock::time_point::max();
};

}  // namespace multitetra
