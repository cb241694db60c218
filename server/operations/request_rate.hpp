// A token-bucket rate limiter: so many requests a second on average, and a burst. What is
// large counts for several requests, and is owed where so much is not left.
//
// Pure: the clock is the caller's, in seconds that never go back.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <unordered_map>

namespace multitetra {

struct RequestRate {
  double per_second = 0;  // 0: no limit.
  double burst = 1;       // The largest burst after idle time; at least 1.
};

// Refills with time and is emptied by requests (a token bucket).
class RateAllowance {
 public:
  RateAllowance(const RequestRate& rate, double now) : left_(rate.burst), since_(now) {}

  // 0 when another request is allowed now: it is counted then, for `cost`. Else the seconds until
  // then; what it costs beyond 1, which is the work to look at it, is counted nevertheless.
  [[nodiscard]] double take(const RequestRate& rate, double now, double cost) {
    left_ = left_at(rate, now);
    since_ = std::max(since_, now);
    const double needed = std::min(cost, 1.0);
    const bool check_rate_limit = left_ >= needed;
    left_ = std::max(left_ - (check_rate_limit ? cost : cost - needed),
                     -kLongestDebt * rate.per_second);
    return check_rate_limit ? 0 : (needed - left_) / rate.per_second;
  }
  // Whether the allowance is as full as without any requests.
  [[nodiscard]] bool is_full(const RequestRate& rate, double now) const {
    return left_at(rate, now) >= rate.burst;
  }

 private:
  [[nodiscard]] double left_at(const RequestRate& rate, double now) const {
    return std::min(rate.burst, left_ + std::max(now - since_, 0.0) * rate.per_second);
  }

  static constexpr double kLongestDebt = 30;  // Seconds.

  double left_;
  double since_;
};

// One allowance for each name, such as a client's address. Memory is bounded: a name with a full
// allowance is forgotten, and beyond `most_names` newcomers share one.
class RatePerName {
 public:
  explicit RatePerName(RequestRate rate, std::size_t most_names = 65'536)
      : rate_(rate), most_names_(most_names), newcomers_(rate, 0) {}

  // As RateAllowance::take().
  [[nodiscard]] double take(const std::string& name, double now, double cost = 1) {
    if (rate_.per_second <= 0) return 0;
    if (const auto known = allowances_.find(name); known != allowances_.end()) {
      return known->second.take(rate_, now, cost);
    }
    if (allowances_.size() >= next_sweep_) sweep(now);
    if (allowances_.size() >= most_names_) return newcomers_.take(rate_, now, cost);
    return allowances_.emplace(name, RateAllowance(rate_, now))
        .first->second.take(rate_, now, cost);
  }
  [[nodiscard]] std::size_t size() const { return allowances_.size(); }
  [[nodiscard]] const RequestRate& rate() const { return rate_; }

 private:
  // Next when there are twice as many as now remain, so that a request costs O(1) on average.
  // While the table is full, that is at most once a second.
  void sweep(double now) {
    if (allowances_.size() >= most_names_ && now < last_sweep_ + 1) return;
    last_sweep_ = now;
    std::erase_if(allowances_, [&](const auto& entry) { return entry.second.is_full(rate_, now); });
    next_sweep_ = std::min(std::max<std::size_t>(64, 2 * allowances_.size()), most_names_);
  }

  RequestRate rate_;
  std::size_t most_names_;
  RateAllowance newcomers_;
  std::unordered_map<std::string, RateAllowance> allowances_;
  std::size_t next_sweep_ = std::min<std::size_t>(64, most_names_);
  double last_sweep_ = -1;
};

}  // namespace multitetra
