// Estimates the bandwidth to a client from the bytes that are queued in the socket. Pure: the
// caller provides the clock.
//
//   rate.write_begins(now, unsent);  ...  rate.write_ends(now, bytes, unsent);
//
// Buffers along the path (of the client, of proxies) absorb the first bytes at any link rate. So a
// low rate is accepted only after bytes were queued for a while, and a high one only after many
// were sent.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "server/core/planning/cost_estimates.hpp"

namespace multitetra {

class BandwidthEstimator {
 public:
  using Clock = std::chrono::steady_clock;

  // `unsent`: bytes queued in the socket.
  void write_begins(Clock::time_point now, std::uint64_t unsent) {
    record(now, unsent);
    if (!has_waiting_) begin(now, unsent);
  }
  void write_ends(Clock::time_point now, std::uint64_t bytes, std::uint64_t unsent) {
    written_ += bytes;
    has_waiting_ = true;
    record(now, unsent);
  }

  [[nodiscard]] double bytes_per_second() const { return bytes_per_second_; }

 private:
  static constexpr std::chrono::milliseconds kMinWait{20};
  static constexpr double kMinBytes = 64 * 1024;
  static constexpr double kMinSeconds = 1e-4;
  static constexpr double kWeight = 0.5;

  void begin(Clock::time_point now, std::uint64_t unsent) {
    since_ = now;
    sent_ = written_ - std::min(written_, unsent);
  }

  void record(Clock::time_point now, std::uint64_t unsent) {
    if (!has_waiting_) return;
    const std::uint64_t sent = written_ - std::min(written_, unsent);
    const auto bytes = static_cast<double>(std::max(sent, sent_) - sent_);
    const double seconds = std::chrono::duration<double>(now - since_).count();
    has_waiting_ = unsent > 0;
    if (!has_waiting_) {
      note_passed(bytes, seconds);
    } else if (now - since_ >= kMinWait) {
      note_waiting(bytes / seconds);
      begin(now, unsent);
    }
  }
  // Records a rate while bytes are queued: the link limits it.
  void note_waiting(double rate) {
    bytes_per_second_ += (is_measured_ ? kWeight : 1) * (rate - bytes_per_second_);
    bytes_per_second_ = std::max(bytes_per_second_, 1000.0);
    is_measured_ = true;
    passed_bytes_ = passed_seconds_ = 0;
  }
  // Records bytes that passed while the queue was empty: the link carries at least this rate.
  void note_passed(double bytes, double seconds) {
    passed_bytes_ += bytes;
    passed_seconds_ += seconds;
    if (passed_bytes_ < kMinBytes) return;
    const double rate = passed_bytes_ / std::max(passed_seconds_, kMinSeconds);
    bytes_per_second_ = std::max(bytes_per_second_, rate);
    passed_bytes_ = passed_seconds_ = 0;
  }

  double bytes_per_second_ = kDefaultBytesPerSecond;
  // A rate was measured while bytes were queued.
  bool is_measured_ = false;
  std::uint64_t written_ = 0;

  // Bytes are being written or queued.
  bool has_waiting_ = false;
  Clock::time_point since_ = {};
  // Bytes sent up to `since_`.
  std::uint64_t sent_ = 0;
  // Bytes sent without long queueing since the last measurement, and the time that took.
  double passed_bytes_ = 0;
  double passed_seconds_ = 0;
};

}  // namespace multitetra
