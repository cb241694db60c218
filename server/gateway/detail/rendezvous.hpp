// Rendezvous hashing: each candidate has a score for a name, and the highest one is chosen. All
// gateways agree without a shared table, and losing a candidate moves only its own names. Pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/checksum.hpp"

namespace multitetra {

[[nodiscard]] inline std::uint64_t rendezvous_score(std::string_view name,
                                                    std::string_view candidate) {
  const std::string both = std::string(name) + '\n' + std::string(candidate);
  return checksum(std::as_bytes(std::span(both)));
}

// Returns indices into `candidates`, best first.
[[nodiscard]] inline std::vector<std::size_t> rendezvous_order(
    std::string_view name, const std::vector<std::string>& candidates) {
  std::vector<std::pair<std::uint64_t, std::size_t>> scores;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    scores.emplace_back(~rendezvous_score(name, candidates[i]), i);
  }
  std::sort(scores.begin(), scores.end());
  std::vector<std::size_t> order;
  for (const auto& [score, index] : scores) order.push_back(index);
  return order;
}

}  // namespace multitetra
