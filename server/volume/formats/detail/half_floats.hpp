// Converts 16-bit floats (IEEE 754 binary16) to 32-bit floats, exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] float float_from_half(std::uint16_t half);

// Converts halves to floats, both in host byte order.
[[nodiscard]] std::vector<std::byte> floats_from_halves(std::span<const std::byte> halves);

// Returns the slices of `header`, of type kF32, from slices of halves in the same order.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_of_halves(std::unique_ptr<StoredSlices> halves,
                                                             const ImageHeader& header);

}  // namespace multitetra
