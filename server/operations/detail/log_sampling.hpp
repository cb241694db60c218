// Limits log lines per name (an address) and in total, so that clients cannot flood the log. The
// next line written has the number of omitted ones.
//
// Pure: the caller provides the clock, in monotonic seconds. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "server/operations/request_rate.hpp"

namespace multitetra {

struct LogRates {
  RequestRate of_a_name = {.per_second = 10, .burst = 100};
  RequestRate of_all = {.per_second = 500, .burst = 5000};
};

class LogSampler {
 public:
  explicit LogSampler(const LogRates& rates = {})
      : of_a_name_(rates.of_a_name, kMaxNames), all_(rates.of_all), of_all_(rates.of_all, 0) {}

  // Returns the number of lines omitted for the name since its last one; nullopt to omit this line.
  [[nodiscard]] std::optional<std::uint64_t> admit(const std::string& name, double now) {
    if (of_a_name_.take(name, now) > 0 || of_all_.take(all_, now, 1) > 0) {
      const bool is_known = left_out_.contains(name) || left_out_.size() < kMaxNames;
      ++left_out_[is_known ? name : std::string()];
      return std::nullopt;
    }
    const auto found = left_out_.find(name);
    if (found == left_out_.end()) return 0;
    const std::uint64_t count = found->second;
    left_out_.erase(found);
    return count;
  }

 private:
  static constexpr std::size_t kMaxNames = 4096;

  RatePerName of_a_name_;
  RequestRate all_;
  RateAllowance of_all_;
  std::unordered_map<std::string, std::uint64_t> left_out_;  // Names above kMaxNames share "".
};

}  // namespace multitetra
