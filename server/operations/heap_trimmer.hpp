// Gives memory back to the system. The allocator keeps what was freed, which after a few large
// surfaces is many times of what is in use.
#pragma once

#include <chrono>
#include <cstdint>

namespace multitetra {

// Before threads begin: fewer pools than threads, and large pieces go back when they are freed.
void trim_heap();

// Decides when trimming the heap is worth its time. The clock is the caller's.
class HeapTrimmer {
 public:
  using Clock = std::chrono::steady_clock;

  // Whether to do it now: some time after work has ended, and now and then while there is no end of
  // it. `work` counts what was done so far; `is_busy` says that some is under way.
  [[nodiscard]] bool is_due(Clock::time_point now, std::uint64_t work, bool is_busy);

 private:
  static constexpr std::chrono::seconds kRest{2};    // Without work, or
  static constexpr std::chrono::seconds kPause{30};  // since it was done last.

  std::uint64_t work_ = 0;  // When it was looked at last.
  bool is_owed_ = false;
  Clock::time_point idle_since_ = {};
  Clock::time_point done_ = {};
};

// All that is free goes back. Takes some ten milliseconds for each GiB.
void return_free_memory();

}  // namespace multitetra
