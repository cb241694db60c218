// Tracks whether a server is reachable, and when to retry it. Pure: the caller provides the clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

namespace multitetra {

class UpstreamHealth {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Change { kNone, kReachable, kLost };

  // After the first failure a server is not contacted for `min_backoff`. Each further failure
  // doubles the time, up to `max_backoff`.
  UpstreamHealth(std::chrono::milliseconds min_backoff, std::chrono::milliseconds max_backoff)
      : min_backoff_(min_backoff), max_backoff_(max_backoff) {}

  // Records success. Returns kReachable if the previous attempt failed or there was none.
  Change record_success() {
    const bool is_new = !std::exchange(was_tried_, true) || has_failed();
    backoff_ = {};
    not_before_ = {};
    return is_new ? Change::kReachable : Change::kNone;
  }

  // Records a failure to answer or a lost connection. Returns kLost if the previous attempt did not
  // fail.
  Change record_failure(Clock::time_point now) {
    const bool is_news = !has_failed();
    was_tried_ = true;
    backoff_ = std::clamp(2 * backoff_, min_backoff_, max_backoff_);
    not_before_ = now + backoff_;
    return is_news ? Change::kLost : Change::kNone;
  }

  // Excludes a server that sent damaged data, for the given time. Returns kLost unless it was
  // excluded already.
  Change quarantine(Clock::time_point now, Clock::duration how_long) {
    const bool is_news = !is_quarantined(now);
    quarantined_until_ = now + how_long;
    return is_news ? Change::kLost : Change::kNone;
  }
  [[nodiscard]] bool is_quarantined(Clock::time_point now) const {
    return now < quarantined_until_;
  }

  [[nodiscard]] bool is_reachable(Clock::time_point now) const {
    return was_tried_ && !has_failed() && !is_quarantined(now);
  }
  [[nodiscard]] bool has_failed() const { return backoff_.count() > 0; }
  [[nodiscard]] bool may_be_tried(Clock::time_point now) const {
    return now >= not_before_ && !is_quarantined(now);
  }
  // Returns when a failed server may be retried.
  [[nodiscard]] Clock::time_point next_try() const { return not_before_; }

 private:
  std::chrono::milliseconds min_backoff_;
  std::chrono::milliseconds max_backoff_;
  bool was_tried_ = false;
  std::chrono::milliseconds backoff_{0};  // 0: the last attempt succeeded.
  Clock::time_point not_before_ = {};
  Clock::time_point quarantined_until_ = {};
};

}  // namespace multitetra
