// The small sections of a prepared dataset, as core takes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "common/request/dataset_info.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"

namespace multitetra {

// Throws DatasetFileError unless the sections "coarse" and "ranges" have the bytes that `info` asks
// for. `place` is for the sentence.
void check_small_sections(const std::filesystem::path& place, const DatasetInfo& info,
                          std::uint64_t coarse_bytes, std::uint64_t ranges_bytes);

// The section "bins". Throws DatasetFileError when these are no edges of bins.
[[nodiscard]] IsovalueBins bins_of(const std::filesystem::path& place,
                                   std::span<const std::byte> bytes);

}  // namespace multitetra
