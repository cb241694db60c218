// Estimates the duration of work from earlier work of the same kind, weighting recent work most.
//
//   WorkCosts costs;
//   costs.expected("head final", /*unseen=*/1.0);   // Seconds.
//   costs.record("head final", 2.5);
//
// Pure: no thread, no clock.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace multitetra {

class WorkCosts {
 public:
  // Returns the expected seconds, or `unseen` for an unknown kind.
  [[nodiscard]] double expected(const std::string& kind, double unseen) const {
    const auto known = seconds_.find(kind);
    return known == seconds_.end() ? unseen : known->second;
  }
  // Records a duration. Ignores work without a kind.
  void record(const std::string& kind, double seconds) {
    constexpr double kWeight = 0.25;
    if (kind.empty()) return;
    if (seconds_.size() >= kMaxKinds && !seconds_.contains(kind)) seconds_.clear();
    const auto [at, is_new] = seconds_.try_emplace(kind, seconds);
    if (!is_new) at->second += kWeight * (seconds - at->second);
  }
  [[nodiscard]] std::size_t size() const { return seconds_.size(); }

  static constexpr std::size_t kMaxKinds = 16'384;

 private:
  std::map<std::string, double> seconds_;
};

}  // namespace multitetra
