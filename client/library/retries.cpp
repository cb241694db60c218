#include "client/library/retries.hpp"

#include <algorithm>
#include <thread>

namespace multitetra {
namespace {

constexpr double kMaxServerDelay = 60;  // Seconds.

}  // namespace

bool Retries::wait_after(const Error& error) {
  if (error.code != ErrorCode::kUnavailable || in_a_row_ >= options_.most) return false;
  std::chrono::milliseconds wait = options_.first_wait;
  for (int i = 0; i < in_a_row_ && wait < options_.longest_wait; ++i) wait *= 2;
  wait = std::min(wait, options_.longest_wait);
  // The delay requested by the server applies if it is longer, up to a limit.
  const std::chrono::duration<double> server_delay(
      std::clamp(error.retry_after, 0.0, kMaxServerDelay));
  wait = std::max(wait, std::chrono::ceil<std::chrono::milliseconds>(server_delay));
  if (options_.deadline - std::chrono::steady_clock::now() < wait) return false;
  ++in_a_row_;
  if (options_.on_retry) options_.on_retry({in_a_row_, wait, error});
  const auto end = std::chrono::steady_clock::now() + wait;
  for (;;) {
    const auto remaining = end - std::chrono::steady_clock::now();
    if (remaining <= remaining.zero()) return true;
    if (options_.interrupt && options_.interrupt()) return false;
    std::this_thread::sleep_for(
        options_.interrupt ? std::min<std::chrono::nanoseconds>(remaining, kInterruptInterval)
                           : remaining);
  }
}

}  // namespace multitetra
