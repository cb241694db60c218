// How long a worker has run a job, without the pauses in which others had its place.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "server/operations/deadline.hpp"

namespace multitetra {

// Thread-safe. 0 at first.
class WorkTime {
 public:
  void begin() {
    const std::lock_guard lock(mutex_);
    since_ = Clock::now();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    if (since_) before_ += Clock::now() - *std::exchange(since_, std::nullopt);
  }
  [[nodiscard]] double seconds(Clock::time_point now = Clock::now()) const {
    const std::lock_guard lock(mutex_);
    return std::chrono::duration<double>(before_ + (since_ ? now - *since_ : Clock::duration{}))
        .count();
  }

 private:
  mutable std::mutex mutex_;
  Clock::duration before_{};
  std::optional<Clock::time_point> since_;  // None between end() and begin().
};

}  // namespace multitetra
