// One budget for several surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// Divides a budget in proportion to the sizes of the surfaces without it. The shares sum to at most
// the budget, and each is at least 1. A budget of 0 means no limit, and so do its shares. Requires
// at most `budget` surfaces unless it is 0.
[[nodiscard]] std::vector<std::uint64_t> shares_of(std::uint64_t budget,
                                                   std::span<const std::uint64_t> sizes);

// A server's estimate of a surface's size without a budget.
struct EstimatedSize {
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
};

// Returns whether there are several requests with a budget to share. Requires at least one request,
// all with the same budget.
[[nodiscard]] bool needs_shared_budget(std::span<const IsosurfaceRequest> requests);

// Fails with kInvalidArgument if there are more requests to share a budget than it has units.
[[nodiscard]] Result<void> check_shared_budget(std::span<const IsosurfaceRequest> requests);

// Gives each request its share. Requires needs_shared_budget(), a successful check_shared_budget(),
// and the size of each surface.
void share_budget(std::span<IsosurfaceRequest> requests, std::span<const EstimatedSize> sizes);

}  // namespace multitetra
