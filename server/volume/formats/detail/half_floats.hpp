// Floats of 16 bits (IEEE 754 binary16), which become floats of 32 bits exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] float float_from_half(std::uint16_t half);

// The bytes of floats from those of halves, both in the byte order of this machine.
[[nodiscard]] std::vector<std::byte> floats_from_halves(std::span<const std::byte> halves);

// Slices of type kF32 from slices of type kU16 that are halves.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_of_halves(std::unique_ptr<StoredSlices> halves,
                                                             const ImageHeader& header);

}  // namespace multitetra
