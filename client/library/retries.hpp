// Decides whether and when an operation that failed on the network is retried.
//
//   Retries retries({.most = 5});
//   auto client = Client::connect(server, {});
//   while (!client && retries.wait_after(client.error().error))
//     client = Client::connect(server, {});
//
// Only failures that may be temporary are retried: a server that cannot be reached, is silent,
// closes the connection or shuts down. Malformed messages, refusals and failed checks would recur.
// A delay in the server's reply (retry_after) is respected, up to one minute.
#pragma once

#include <chrono>
#include <functional>
#include <utility>

#include "client/library/interrupt.hpp"
#include "common/base/result.hpp"

namespace multitetra {

struct Retry {
  // Consecutive retries without progress.
  int number = 1;
  std::chrono::milliseconds wait{0};
  Error reason;
};

struct RetryOptions {
  int most = 5;  // Consecutive retries without progress. 0: none.
  // The wait before the first retry. Doubles with each retry, up to `longest_wait`.
  std::chrono::milliseconds first_wait{250};
  std::chrono::milliseconds longest_wait{8'000};
  // No retry is made whose wait would end later.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<void(const Retry&)> on_retry = {};  // Called before each wait.
  // Ends a wait; then no retry is made.
  Interrupt interrupt = {};
};

class Retries {
 public:
  explicit Retries(RetryOptions options) : options_(std::move(options)) {}

  // Waits and returns true, or returns false at once if the operation must not be retried.
  [[nodiscard]] bool wait_after(const Error& error);
  // Resets the count and the waits after progress.
  void progress() { in_a_row_ = 0; }

 private:
  RetryOptions options_;
  int in_a_row_ = 0;
};

}  // namespace multitetra
