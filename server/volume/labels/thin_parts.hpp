// Counts the samples in parts one sample thick, which simplification removes first.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>

namespace multitetra {

// Returns for each label the number of samples in no cube of 2 x 2 x 2 samples of the label; omits
// labels without such samples, and 0. Calls `read` for the labels of each slice, in order. Holds
// two slices in memory.
[[nodiscard]] std::map<std::int32_t, std::uint64_t> thin_samples(
    const std::array<std::int32_t, 3>& dims,
    const std::function<void(std::int32_t, std::span<std::int32_t>)>& read);

}  // namespace multitetra
