// Returns free memory to the system. After a few large surfaces the allocator retains many times
// the memory in use.
#pragma once

#include <chrono>
#include <cstdint>

namespace multitetra {

// Configures the allocator: few arenas, and direct release of large blocks. Call before starting
// threads.
void configure_allocator();

// Decides when to trim the heap. The caller provides the clock.
class HeapTrimmer {
 public:
  using Clock = std::chrono::steady_clock;

  // Returns whether to trim now: some time after work has ended, and periodically during continuous
  // work. `work` counts the work done so far; `is_busy` means that some is in progress.
  [[nodiscard]] bool is_due(Clock::time_point now, std::uint64_t work, bool is_busy);

 private:
  static constexpr std::chrono::seconds kIdleTime{2};  // Idle time before trimming.
  static constexpr std::chrono::seconds kPause{30};    // Between trims while busy.

  std::uint64_t work_ = 0;  // The value of `work` at the last call.
  bool is_trim_pending_ = false;
  Clock::time_point idle_since_ = {};
  Clock::time_point done_ = {};
};

// Returns all free memory to the system. Takes about ten milliseconds per GiB.
void return_free_memory();

}  // namespace multitetra
