// Options of requests to HTTP and S3 stores.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string_view>

namespace multitetra {

struct HttpStoreOptions {
  std::size_t connections = 16;  // At most, at the same time; at least 1.
  // The most attempts of one request; at least 1.
  int tries = 5;
  std::chrono::milliseconds first_pause{100};  // Before the second try.
  // Also limits Retry-After.
  std::chrono::milliseconds longest_pause{5000};
  std::chrono::seconds connecting{20};
  std::chrono::seconds stalled{30};  // Less than 256 bytes a second for so long end a try.
  // For a request with all its attempts.
  std::chrono::milliseconds deadline{600000};
  // After a request that failed for good, requests to this host fail at once for so long.
  std::chrono::milliseconds rest_after_failure{0};
  bool follow = false;  // Redirects and keys may lead to other hosts and out of the address.
  // Called before every retry of a request, on the calling thread.
  std::function<void()> tries_again = {};
};

// Whether the text begins with http://, https:// or s3://.
[[nodiscard]] bool is_address(std::string_view text);

}  // namespace multitetra
