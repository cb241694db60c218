#include "common/request/shared_budget.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

namespace multitetra {

std::vector<std::uint64_t> shares_of(std::uint64_t budget, std::span<const std::uint64_t> sizes) {
  if (budget == 0) return std::vector<std::uint64_t>(sizes.size(), 0);
  assert(sizes.size() <= budget);
  double all = 0;
  for (const std::uint64_t size : sizes)
    all += static_cast<double>(std::max<std::uint64_t>(size, 1));
  // One for each, and the rest in proportion, so rounding down never makes a share 0.
  const auto rest = static_cast<double>(budget - sizes.size());
  std::vector<std::uint64_t> shares;
  for (const std::uint64_t size : sizes) {
    const double part = static_cast<double>(std::max<std::uint64_t>(size, 1)) / all;
    shares.push_back(1 + static_cast<std::uint64_t>(std::floor(rest * part)));
  }
  return shares;
}

bool needs_shared_budget(std::span<const IsosurfaceRequest> requests) {
  return requests.size() > 1 && (requests[0].max_triangles > 0 || requests[0].max_bytes > 0);
}

Result<void> check_shared_budget(std::span<const IsosurfaceRequest> requests) {
  if (!needs_shared_budget(requests)) return {};
  for (const std::uint64_t budget : {requests[0].max_triangles, requests[0].max_bytes}) {
    if (budget == 0 || budget >= requests.size()) continue;
    return fail(ErrorCode::kInvalidArgument, "A budget of " + std::to_string(budget) +
                                                 " cannot be shared by " +
                                                 std::to_string(requests.size()) + " surfaces.");
  }
  return {};
}

void share_budget(std::span<IsosurfaceRequest> requests, std::span<const EstimatedSize> sizes) {
  assert(needs_shared_budget(requests) && sizes.size() == requests.size());
  std::vector<std::uint64_t> triangles;
  std::vector<std::uint64_t> bytes;
  for (const EstimatedSize& size : sizes) {
    triangles.push_back(size.triangles);
    bytes.push_back(size.bytes);
  }
  const auto of_triangles = shares_of(requests[0].max_triangles, triangles);
  const auto of_bytes = shares_of(requests[0].max_bytes, bytes);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    requests[i].max_triangles = of_triangles[i];
    requests[i].max_bytes = of_bytes[i];
  }
}

}  // namespace multitetra
