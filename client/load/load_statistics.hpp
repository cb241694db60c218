// Counters of what clients observed. Each thread has its own; they are added at the end.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// Durations in seconds. All values are kept.
class Times {
 public:
  void add(double seconds) { seconds_.push_back(seconds); }
  void add(const Times& other) {
    seconds_.insert(seconds_.end(), other.seconds_.begin(), other.seconds_.end());
  }

  [[nodiscard]] std::size_t count() const { return seconds_.size(); }
  [[nodiscard]] double mean() const;
  // Returns the smallest value not exceeded by this fraction of all values: 0.5 is the median, 1
  // the maximum. Returns 0 if there are none.
  [[nodiscard]] double quantile(double part) const;

 private:
  std::vector<double> seconds_;
};

struct LoadStatistics {
  // Started streams. Each ends as one of: complete, replaced, failed, unfinished.
  std::uint64_t streams = 0;
  std::uint64_t complete = 0;
  // Replaced by the script's next request.
  std::uint64_t replaced = 0;
  // Refused by the server, or failed a check.
  std::uint64_t failed = 0;
  // Still running after the grace period.
  std::uint64_t unfinished = 0;

  // Rejections with a retry delay, after which the client retried.
  std::uint64_t retried_after_delay = 0;

  std::uint64_t steps = 0;
  std::uint64_t tiles = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t wire_bytes = 0;  // Received bytes, counted above TLS.
  double seconds = 0;            // From the start of the run until the last tile.

  std::uint64_t connections = 0;  // Connections that received a Welcome.
  std::uint64_t lost_connections = 0;
  std::uint64_t failed_attempts = 0;             // Attempts to connect that ended without Welcome.
  std::uint64_t clients_without_connection = 0;  // Never connected.

  // Streams assembled with all checks.
  std::uint64_t thorough_streams = 0;
  std::uint64_t tiles_decoded = 0;
  // Steps compared with the same step of another stream.
  std::uint64_t steps_compared = 0;
  // Tiles sent more than once to one client for one request, over all its connections.
  std::uint64_t tiles_sent_twice = 0;
  // The texts of the first failed checks, at most kMaxTexts.
  std::vector<std::string> failed_checks;
  std::uint64_t checks_failed = 0;

  struct Occurrences {
    std::uint64_t count = 0;
    std::string example;
  };
  std::map<std::string, Occurrences> errors;  // By error code.

  // From connecting to the Welcome.
  Times connect;
  // From a stream's request to its first tile. This and the following times include reconnecting.
  Times first_tile;
  // From a stream's request to its first complete and checked step.
  Times first_step;
  // From a complete stream's request to its last tile.
  Times last_tile;
  // From a complete stream's request to its end.
  Times whole;

  static constexpr std::size_t kMaxTexts = 20;
  void add_error(const Error& error);
  void add_failed_check(const std::string& text);
  void add(const LoadStatistics& other);
};

}  // namespace multitetra
