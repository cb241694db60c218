// Converts 16-bit floats (IEEE 754 binary16) to 32-bit floats, exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

[[nodiscard]] float float_from_half(std::uint16_t half);

// Converts halves to floats, both in host byte order.
[[nodiscard]] std::vector<std::byte> floats_from_halves(std::span<const std::byte> halves);

// Returns slices of type kF32 from halves that start at `offset` in a file (plain_slices.hpp).
[[nodiscard]] std::unique_ptr<StoredSlices> halves_in_file(const std::filesystem::path& file,
                                                           std::uint64_t offset, Endian endian,
                                                           const ImageHeader& header);

}  // namespace multitetra
