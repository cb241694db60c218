// Waits for events in other threads without guessing how long they take. What does not happen
// within half a minute is a failure.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace multitetra::testing {

inline constexpr std::chrono::seconds kLongestWait{30};

// A number that threads change and others wait for.
class Count {
 public:
  Count& operator++() { return add(1); }
  Count& operator--() { return add(-1); }
  operator int() const {  // NOLINT: it is one.
    const std::lock_guard lock(mutex_);
    return value_;
  }
  // Returns whether the number becomes `wanted`.
  [[nodiscard]] bool reaches(int wanted) {
    return becomes([=](int value) { return value == wanted; });
  }
  [[nodiscard]] bool reaches_at_least(int wanted) {
    return becomes([=](int value) { return value >= wanted; });
  }

 private:
  Count& add(int more) {
    {
      const std::lock_guard lock(mutex_);
      value_ += more;
    }
    changed_.notify_all();
    return *this;
  }
  bool becomes(const std::function<bool(int)>& is_right) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kLongestWait, [&] { return is_right(value_); });
  }

  mutable std::mutex mutex_;  // Guards value_.
  std::condition_variable changed_;
  int value_ = 0;
};

// Blocks callers until it is opened.
class Gate {
 public:
  void open() {
    {
      const std::lock_guard lock(mutex_);
      is_open_ = true;
    }
    opened_.notify_all();
  }
  // Returns true if it was opened, false if the wait was stopped.
  bool pass(const std::stop_token& stop = {}) {
    std::unique_lock lock(mutex_);
    return opened_.wait_for(lock, stop, kLongestWait, [this] { return is_open_; });
  }

 private:
  std::mutex mutex_;  // Guards is_open_.
  std::condition_variable_any opened_;
  bool is_open_ = false;
};

// Polls a condition that cannot be waited for; returns whether it becomes true.
inline bool eventually(const std::function<bool()>& happened) {
  const auto end = std::chrono::steady_clock::now() + kLongestWait;
  while (!happened()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace multitetra::testing
