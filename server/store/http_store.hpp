// Objects below an address: http://, https://, or s3://bucket/prefix. Read by plain GET with ranges
// through libcurl (HTTP/1.1, or 2 where the server offers it; connections are kept), which is seen
// by http_store.cpp alone.
//
// What a store answers is not believed: a 206 must be of the range that was asked for, and a body
// as long as its header promised. What may pass (no connection, a body that ends too early, 429,
// 5xx) is tried again after a while that doubles and is random between its half and its whole, or
// after what Retry-After says.
//
// Only the operator's own command lines name addresses; no request of a client ever does.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/store/object_store.hpp"

namespace multitetra {

struct HttpStoreOptions {
  std::size_t connections = 16;                   // At most, at the same time; at least 1.
  int tries = 5;                                  // Of one request; at least 1.
  std::chrono::milliseconds first_pause{100};     // Before the second try.
  std::chrono::milliseconds longest_pause{5000};  // Also of what Retry-After asks for.
  std::chrono::seconds connecting{20};
  std::chrono::seconds stalled{30};  // Less than 256 bytes a second for so long end a try.
  std::chrono::milliseconds deadline{600000};  // Of a request with all its tries.
  // After a request that failed for good nobody else waits for this store: so long all fail at
  // once.
  std::chrono::milliseconds rest_after_failure{0};
  bool follow = false;  // Redirects and keys may lead to other hosts and out of the address.
  // Told of every try after a request's first one, on the thread that asks.
  std::function<void()> tries_again = {};
};

[[nodiscard]] bool is_address(std::string_view text);

// s3:// addresses become https ones of AWS, or of AWS_ENDPOINT_URL where that is set. With
// AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the environment (and AWS_SESSION_TOKEN,
// AWS_REGION, where needed) requests to s3:// are signed with Signature Version 4; without them the
// bucket must be public. Redirects are followed to the same host, from http to https but not back,
// and with options.follow to other hosts, which never get credentials: neither those of S3 nor a
// user and password of the address. 401 and 403 are StoreRefusal, for they say nothing of whether
// there is an object. Throws StoreError for an address that is none.
[[nodiscard]] std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                                      const HttpStoreOptions& options = {});

}  // namespace multitetra
