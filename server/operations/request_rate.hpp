// A token-bucket rate limiter: an average rate and a burst. A large request counts for several, and
// may leave a debt.
//
// Pure: the caller provides the clock, in monotonic seconds.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <unordered_map>

namespace multitetra {

struct RequestRate {
  double per_second = 0;  // 0: no limit.
  double burst = 1;       // The most requests after idle time; at least 1.
};

// A token bucket: refilled by time, drained by requests.
class RateAllowance {
 public:
  RateAllowance(const RequestRate& rate, double now) : left_(rate.burst), since_(now) {}

  // Charges a request with `cost` and returns 0 if it is allowed now. Otherwise returns the seconds
  // to wait, and charges only the cost above 1, as even a refused large request takes time to read.
  [[nodiscard]] double take(const RequestRate& rate, double now, double cost) {
    left_ = remaining_at(rate, now);
    since_ = std::max(since_, now);
    const double needed = std::min(cost, 1.0);
    const bool is_allowed = left_ >= needed;
    left_ =
        std::max(left_ - (is_allowed ? cost : cost - needed), -kMaxDebtSeconds * rate.per_second);
    return is_allowed ? 0 : (needed - left_) / rate.per_second;
  }
  // Returns whether the allowance is as full as without any requests.
  [[nodiscard]] bool is_full(const RequestRate& rate, double now) const {
    return remaining_at(rate, now) >= rate.burst;
  }

 private:
  [[nodiscard]] double remaining_at(const RequestRate& rate, double now) const {
    return std::min(rate.burst, left_ + std::max(now - since_, 0.0) * rate.per_second);
  }

  static constexpr double kMaxDebtSeconds = 30;  // Seconds.

  double left_;
  double since_;
};

// One allowance per name, such as a client's address. Memory is bounded: names with full allowances
// are removed, and new names beyond `max_names` share one.
class RatePerName {
 public:
  explicit RatePerName(RequestRate rate, std::size_t max_names = 65'536)
      : rate_(rate), max_names_(max_names), newcomers_(rate, 0) {}

  // Does the same as RateAllowance::take() for the allowance of a name.
  [[nodiscard]] double take(const std::string& name, double now, double cost = 1) {
    if (rate_.per_second <= 0) return 0;
    if (const auto known = allowances_.find(name); known != allowances_.end()) {
      return known->second.take(rate_, now, cost);
    }
    if (allowances_.size() >= next_sweep_) sweep(now);
    if (allowances_.size() >= max_names_) return newcomers_.take(rate_, now, cost);
    return allowances_.emplace(name, RateAllowance(rate_, now))
        .first->second.take(rate_, now, cost);
  }
  [[nodiscard]] std::size_t size() const { return allowances_.size(); }
  [[nodiscard]] const RequestRate& rate() const { return rate_; }

 private:
  // Removes full allowances. Repeated when the table has doubled, so a request costs amortized
  // O(1); at most once a second while the table is full.
  void sweep(double now) {
    if (allowances_.size() >= max_names_ && now < last_sweep_ + 1) return;
    last_sweep_ = now;
    std::erase_if(allowances_, [&](const auto& entry) { return entry.second.is_full(rate_, now); });
    next_sweep_ = std::min(std::max<std::size_t>(64, 2 * allowances_.size()), max_names_);
  }

  RequestRate rate_;
  std::size_t max_names_;
  RateAllowance newcomers_;
  std::unordered_map<std::string, RateAllowance> allowances_;
  std::size_t next_sweep_ = std::min<std::size_t>(64, max_names_);
  double last_sweep_ = -1;
};

}  // namespace multitetra
