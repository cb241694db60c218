// The samples of each label in parts one sample thick, which simplification removes first.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>

namespace multitetra {

// The samples of each label that lie in no cube of 2 x 2 x 2 samples of it; labels without such
// samples, and 0, are left out. `read` gives the labels of a slice and is called for each one,
// in order. Needs memory for two slices.
[[nodiscard]] std::map<std::int32_t, std::uint64_t> thin_samples(
    const std::array<std::int32_t, 3>& dims,
    const std::function<void(std::int32_t, std::span<std::int32_t>)>& read);

}  // namespace multitetra
