// HTTP requests with retries, over connections that are kept: libcurl (HTTP/1.1, or 2 where the
// server offers it), which is seen by the sources of this folder alone.
//
// Responses are checked: a 206 must be of the requested range, and a body as long as its
// header promised. What may pass (no connection, a body that ends too early, 429, 5xx) is tried
// again after a pause that doubles and is random between its half and its whole, or after what
// Retry-After says.
//
// Redirects are followed to the same host, and from http to its https; to other hosts only with
// options.follow, and there without credentials.
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
#include "server/store/http_options.hpp"

namespace multitetra {

struct HttpRequest {
  std::string address;
  std::string method = "GET";
  // At least one byte; absent: the whole object.
  std::optional<ByteRange> range = std::nullopt;
  std::vector<std::string> headers = {};
  std::span<const std::byte> body = {};
  std::uint64_t most = 0;  // Bytes of the answer; a larger one is an error.
};

struct HttpAnswer {
  long status = 0;  // 2xx; or a 4xx that no retry changes.
  std::vector<std::byte> bytes;
  std::string etag;
  std::string last_modified;
  // The size of the whole object after a 206; 0 if unknown.
  std::uint64_t total = 0;

  [[nodiscard]] bool is_good() const { return status >= 200 && status < 300; }
};

// Safe to use from several threads at once; more than `connections` of them wait.
class StoreClient {
 public:
  // With `signs_for_s3` requests carry Signature Version 4 where the environment has keys.
  StoreClient(bool signs_for_s3, const HttpStoreOptions& options);
  ~StoreClient();
  StoreClient(const StoreClient&) = delete;
  StoreClient& operator=(const StoreClient&) = delete;

  // Throws StoreError when there is no answer, or none that can be used.
  [[nodiscard]] HttpAnswer send(const HttpRequest& request);

  [[nodiscard]] std::size_t connections() const { return options_.connections; }

 private:
  struct Credentials;
  struct Handle;
  struct Outcome;
  void fail_while_resting(const std::string& address);
  void rest(const std::string& problem);
  Outcome attempted(const HttpRequest& request, std::chrono::milliseconds left, HttpAnswer& answer);
  Outcome attempted_along_redirects(Handle& handle, const HttpRequest& request,
                                    std::chrono::milliseconds left, HttpAnswer& answer);
  std::unique_ptr<Handle> idle_handle();
  void give_back(std::unique_ptr<Handle> handle);

  HttpStoreOptions options_;
  std::string user_;
  std::string sigv4_;
  std::string session_;
  std::mutex mutex_;  // Guards what follows.
  std::condition_variable is_free_;
  std::size_t free_;  // Connections that may be used besides.
  std::vector<std::unique_ptr<Handle>> idle_;
  std::chrono::steady_clock::time_point rests_until_;
  std::string rests_since_;  // The error at that time.
};

}  // namespace multitetra
