// One budget for several surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// The shares of a budget, in proportion to what each surface would take without it; together at
// most the budget, and each at least 1. A budget of 0 stands for no limit, and so do its shares.
// Requires no more surfaces than a budget that is none has triangles or bytes.
[[nodiscard]] std::vector<std::uint64_t> shares_of(std::uint64_t budget,
                                                   std::span<const std::uint64_t> sizes);

// A server's estimate of the size of a surface without a budget.
struct EstimatedSize {
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
};

// Whether the requests, of which there is at least one and which all have the first one's budget,
// are several that must share it.
[[nodiscard]] bool needs_shared_budget(std::span<const IsosurfaceRequest> requests);

// kInvalidArgument where they must, and are more than the budget has triangles or bytes.
[[nodiscard]] Result<void> check_shared_budget(std::span<const IsosurfaceRequest> requests);

// Gives each of them its share. Requires needs_shared_budget(), a good check_shared_budget(), and
// the size of each.
void share_budget(std::span<IsosurfaceRequest> requests, std::span<const EstimatedSize> sizes);

}  // namespace multitetra
