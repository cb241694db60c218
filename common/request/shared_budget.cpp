#include "common/request/shared_budget.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace multitetra {

std::vector<std::uint64_t> shares_of(std::uint64_t budget, std::span<const std::uint64_t> sizes) {
  if (budget == 0) return std::vector<std::uint64_t>(sizes.size(), 0);
  assert(sizes.size() <= budget);
  double all = 0;
  for (const std::uint64_t size : sizes)
    all += static_cast<double>(std::max<std::uint64_t>(size, 1));
  // One for each, and the rest in proportion: so rounding down never makes a share none.
  const auto rest = static_cast<double>(budget - sizes.size());
  std::vector<std::uint64_t> shares;
  for (const std::uint64_t size : sizes) {
    const double part = static_cast<double>(std::max<std::uint64_t>(size, 1)) / all;
    shares.push_back(1 + static_cast<std::uint64_t>(std::floor(rest * part)));
  }
  return shares;
}

}  // namespace multitetra
