// Detects idle clients. The caller provides the clock.
//
//   IdleWatch idleness(/*limit=*/600s, now);     // 0: no limit.
//   idleness.record_activity(now);               // A message arrived, or work finished.
//   if (idleness.is_exceeded(now, is_busy)) ...
#pragma once

#include <chrono>

namespace multitetra {

class IdleWatch {
 public:
  using Clock = std::chrono::steady_clock;

  IdleWatch(std::chrono::milliseconds limit, Clock::time_point now) : limit_(limit), last_(now) {}

  void record_activity(Clock::time_point now) { last_ = now; }
  [[nodiscard]] Clock::time_point last() const { return last_; }
  // Returns whether the last record_activity() is longer ago than the limit. Being busy counts as
  // activity.
  [[nodiscard]] bool is_exceeded(Clock::time_point now, bool is_busy) {
    if (is_busy) last_ = now;
    return limit_.count() > 0 && last_ + limit_ <= now;
  }

 private:
  std::chrono::milliseconds limit_;
  Clock::time_point last_;
};

}  // namespace multitetra
