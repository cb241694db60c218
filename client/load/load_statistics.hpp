// Counters of what clients experienced. Each thread has its own; they are added up at the end.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// Durations in seconds, all of them kept.
class Times {
 public:
  void add(double seconds) { seconds_.push_back(seconds); }
  void add(const Times& other) {
    seconds_.insert(seconds_.end(), other.seconds_.begin(), other.seconds_.end());
  }

  [[nodiscard]] std::size_t count() const { return seconds_.size(); }
  [[nodiscard]] double mean() const;
  // The smallest that is not exceeded by this part of all: 0.5 is the median, 1 the maximum. 0 of
  // none.
  [[nodiscard]] double quantile(double part) const;

 private:
  std::vector<double> seconds_;
};

struct LoadStatistics {
  // Streams, each in the end one of: complete, replaced, failed, unfinished.
  std::uint64_t streams = 0;
  std::uint64_t complete = 0;
  std::uint64_t replaced = 0;    // By the user's next request, as the script has it.
  std::uint64_t failed = 0;      // Refused by the server, or a check failed.
  std::uint64_t unfinished = 0;  // When the time and the grace after it were over.

  // Rejections with a retry delay, after which the client retried.
  std::uint64_t retried_after_delay = 0;

  std::uint64_t steps = 0;
  std::uint64_t tiles = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t wire_bytes = 0;  // As received, above TLS.
  double seconds = 0;            // From the beginning of the run until the last tile came.

  std::uint64_t connections = 0;  // Connections that received a Welcome.
  std::uint64_t lost_connections = 0;
  std::uint64_t failed_attempts = 0;             // To connect and be welcomed.
  std::uint64_t clients_without_connection = 0;  // To the end.

  std::uint64_t thorough_streams = 0;  // Assembled with all checks.
  std::uint64_t tiles_decoded = 0;
  std::uint64_t steps_compared = 0;    // With the same step as another stream had it.
  std::uint64_t tiles_sent_twice = 0;  // To one client for one request, over all its connections.
  // At most kMaxTexts are reported.
  std::vector<std::string> failed_checks;
  std::uint64_t checks_failed = 0;

  struct Occurrences {
    std::uint64_t count = 0;
    std::string example;
  };
  std::map<std::string, Occurrences> errors;  // By their code.

  Times connect;     // Until the Welcome.
  Times first_tile;  // From asking, lost connections included, as are the next three.
  Times first_step;  // Complete and checked.
  // Times of complete streams.
  Times last_tile;
  Times whole;  // Likewise, until their end.

  static constexpr std::size_t kMaxTexts = 20;
  void add_error(const Error& error);
  void add_failed_check(const std::string& text);
  void add(const LoadStatistics& other);
};

}  // namespace multitetra
