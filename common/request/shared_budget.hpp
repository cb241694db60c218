// One budget for several surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace multitetra {

// The shares of a budget, in proportion to what each surface would take without it; together at
// most the budget, and each at least 1. A budget of 0 stands for no limit, and so do its shares.
// Requires no more surfaces than a budget that is none has triangles or bytes.
[[nodiscard]] std::vector<std::uint64_t> shares_of(std::uint64_t budget,
                                                   std::span<const std::uint64_t> sizes);

}  // namespace multitetra
