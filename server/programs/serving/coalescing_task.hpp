// A task that runs on its own thread, and again on request.
//
//   CoalescingTask rescan([&] { server.offer(datasets.read()); });
//   rescan.request();  // Thread-safe; does not block.
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

  void request() {
    const std::lock_guard lock(mutex_);
    is_requested_ = true;
    requested_.notify_one();
  }

 private:
  void run(const std::stop_token& stop) {
    for (;;) {
      std::unique_lock lock(mutex_);
      if (!requested_.wait(lock, stop, [this] { return is_requested_; })) return;
      is_requested_ = false;
      lock.unlock();
      work_();
    }
  }

  std::function<void()> work_;
  std::mutex mutex_;  // Guards is_requested_.
  std::condition_variable_any requested_;
  bool is_requested_ = false;
  std::jthread thread_;  // Joined first.
};

}  // namespace multitetra
