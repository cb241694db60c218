// Options of requests to HTTP and S3 stores.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string_view>

namespace multitetra {

struct HttpStoreOptions {
  std::size_t connections = 16;  // Maximum number of concurrent connections; at least 1.
  // Maximum number of attempts per request; at least 1.
  int max_attempts = 5;
  std::chrono::milliseconds first_pause{100};  // Before the second attempt.
  // The longest pause between attempts, also if Retry-After is longer.
  std::chrono::milliseconds longest_pause{5000};
  std::chrono::seconds connect_timeout{20};
  // Aborts attempts below 256 bytes/s for this long.
  std::chrono::seconds stall_timeout{30};
  // Time limit of a request, including all attempts.
  std::chrono::milliseconds deadline{600000};
  // The time for which requests to a host fail at once after a request to it has finally failed.
  std::chrono::milliseconds cooldown_after_failure{0};
  // Permits redirects to other hosts, and keys that lead out of the address.
  bool allow_other_hosts = false;
  // Called on the requesting thread before every retry.
  std::function<void()> on_retry = {};
};

// Returns whether the text begins with http://, https:// or s3://.
[[nodiscard]] bool is_address(std::string_view text);

}  // namespace multitetra
