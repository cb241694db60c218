// HTTP requests with retries over persistent connections, by libcurl (HTTP/1.1, or 2 where the
// server offers it). Only this folder includes libcurl's headers.
//
// Responses are checked: a 206 must contain the requested range, and a body must have the announced
// length. Transient failures (no connection, a truncated body, 429, 5xx) are retried after a pause
// that doubles each time, randomized between half and all of it, and is at least Retry-After.
//
// Redirects are followed on the same host, including from http to https, and with options.follow to
// other hosts, which receive no credentials.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/store/detail/content_range.hpp"
#include "server/store/detail/request_signature.hpp"
#include "server/store/http_options.hpp"

namespace multitetra {

struct StoreRequest {
  std::string address;
  std::string method = "GET";
  // At least one byte; absent means the whole object.
  std::optional<StoreRange> range = std::nullopt;
  std::vector<std::string> headers = {};
  std::span<const std::byte> body = {};
  std::uint64_t most = 0;  // Maximum size of the response in bytes; a larger one is an error.
};

struct HttpAnswer {
  long status = 0;  // 2xx, or a 4xx that no retry can change.
  std::vector<std::byte> bytes;
  std::string etag;
  std::string last_modified;
  // For a 206, the size of the whole object; 0 if unknown.
  std::uint64_t total = 0;

  [[nodiscard]] bool is_good() const { return status >= 200 && status < 300; }
};

// Safe to use from several threads at once. Requests beyond options.connections wait.
class StoreClient {
 public:
  // With `signs_for_s3`, signs requests with Signature Version 4 if the environment has keys.
  StoreClient(bool signs_for_s3, const HttpStoreOptions& options);
  ~StoreClient();
  StoreClient(const StoreClient&) = delete;
  StoreClient& operator=(const StoreClient&) = delete;

  // Throws StoreError if there is no usable response.
  [[nodiscard]] HttpAnswer send(const StoreRequest& request);

  [[nodiscard]] std::size_t connections() const { return options_.connections; }

 private:
  struct Credentials;
  struct Handle;
  struct Outcome;
  void check_cooldown(const std::string& address);
  void start_cooldown(const std::string& problem);
  Outcome try_request(const StoreRequest& request, std::chrono::milliseconds left,
                      HttpAnswer& answer);
  Outcome try_with_redirects(Handle& handle, const StoreRequest& request,
                             std::chrono::milliseconds left, HttpAnswer& answer);
  std::unique_ptr<Handle> idle_handle();
  void return_handle(std::unique_ptr<Handle> handle);

  HttpStoreOptions options_;
  SigningKey key_;
  std::mutex mutex_;  // Guards the following members.
  std::condition_variable is_free_;
  std::size_t free_;  // Number of connections that may still be used.
  std::vector<std::unique_ptr<Handle>> idle_;
  std::chrono::steady_clock::time_point cooldown_until_;
  std::string cooldown_reason_;  // The error that caused the cooldown.
};

}  // namespace multitetra
