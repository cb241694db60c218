// The minimum transfer rate for a file that occupies shared resources while it is sent. The caller
// provides the clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace multitetra {

class MinTransferRate {
 public:
  using Clock = std::chrono::steady_clock;

  // Each piece must be sent within `timeout`, and all pieces within `timeout` plus their duration
  // at `bytes_per_second` (0: no limit).
  MinTransferRate(Clock::time_point began, Clock::duration timeout, std::uint64_t bytes_per_second)
      : began_(began), timeout_(timeout), bytes_per_second_(bytes_per_second) {}

  // Returns when `bytes` bytes must have been sent, if the last piece of them begins now.
  [[nodiscard]] Clock::time_point deadline(Clock::time_point now, std::uint64_t bytes) const {
    const Clock::time_point of_the_piece = now + timeout_;
    if (bytes_per_second_ == 0) return of_the_piece;
    const std::chrono::duration<double> at_least(static_cast<double>(bytes) /
                                                 static_cast<double>(bytes_per_second_));
    return std::min(of_the_piece,
                    began_ + timeout_ + std::chrono::duration_cast<Clock::duration>(at_least));
  }

 private:
  Clock::time_point began_;
  Clock::duration timeout_;
  std::uint64_t bytes_per_second_;
};

}  // namespace multitetra
