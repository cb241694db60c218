// A task that runs on its own thread, and again on request.
//
//   CoalescingTask rescan([&] { server.offer(datasets.read()); });
//   rescan.ask();  // Thread-safe; does not block.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace multitetra {

// Requests during a run cause one more run. The destructor waits for the current run. The work must
// not throw.
class CoalescingTask {
 public:
  explicit CoalescingTask(std::function<void()> work)
      : work_(std::move(work)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void ask() {
    const std::lock_guard lock(mutex_);
    is_asked_ = true;
    asked_.notify_one();
  }

 private:
  void run(const std::stop_token& stop) {
    for (;;) {
      std::unique_lock lock(mutex_);
      if (!asked_.wait(lock, stop, [this] { return is_asked_; })) return;
      is_asked_ = false;
      lock.unlock();
      work_();
    }
  }

  std::function<void()> work_;
  std::mutex mutex_;  // Guards is_asked_.
  std::condition_variable_any asked_;
  bool is_asked_ = false;
  std::jthread thread_;  // Joined first.
};

}  // namespace multitetra
