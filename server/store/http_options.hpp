// How requests to stores behind addresses are made.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string_view>

namespace multitetra {

struct HttpStoreOptions {
  std::size_t connections = 16;                   // At most, at the same time; at least 1.
  int tries = 5;                                  // Of one request; at least 1.
  std::chrono::milliseconds first_pause{100};     // Before the second try.
  std::chrono::milliseconds longest_pause{5000};  // Also of what Retry-After asks for.
  std::chrono::seconds connecting{20};
  std::chrono::seconds stalled{30};  // Less than 256 bytes a second for so long end a try.
  std::chrono::milliseconds deadline{600000};  // Of a request with all its tries.
  // After a request that failed for good, requests to this host fail at once for so long.
  std::chrono::milliseconds rest_after_failure{0};
  bool follow = false;  // Redirects and keys may lead to other hosts and out of the address.
  // Called before every try after a request's first one, on the thread that asks.
  std::function<void()> tries_again = {};
};

// Whether the text begins with http://, https:// or s3://.
[[nodiscard]] bool is_address(std::string_view text);

}  // namespace multitetra
