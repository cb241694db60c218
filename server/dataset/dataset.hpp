// A prepared dataset: a volume with its facts and its errors for every isovalue. Immutable, shared
// by pointer-to-const among all sessions.
//
//   const DatasetPtr head = open_dataset("head.mtd");
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "common/mesh/lattice.hpp"
#include "common/request/dataset_info.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The largest grid has 2^14 steps a side. Of grids beyond 2^12 not every lattice resolution stays
// within kMaxLatticeBits; those that do not are refused when they are asked for.
inline constexpr std::int32_t kMaxGridExponent = 14;
static_assert(kMaxGridExponent + kDefaultLatticeResolution <= kMaxLatticeBits);
static_assert((std::int64_t{1} << kMaxGridExponent) + 1 == kMaxSide);

using DatasetPtr = std::shared_ptr<const PreparedVolume>;

// Maps the file into memory and verifies all but its large sections, see prepared_file.hpp. Damage
// that is found later throws DatasetFileError out of whoever reads the brick. Throws
// DatasetFileError.
[[nodiscard]] DatasetPtr open_dataset(const std::filesystem::path& path);

// All samples in one piece, for the exact pass over a volume. Needs memory for them, and reads
// every brick.
[[nodiscard]] Volume whole_volume(const PreparedVolume& dataset);

}  // namespace multitetra
