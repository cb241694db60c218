// A prepared dataset: a volume with its facts and its errors for every isovalue. Immutable, shared
// by pointer-to-const among all sessions.
//
//   const DatasetPtr head = open_dataset("head.mtd");
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/lattice.hpp"
#include "common/request/dataset_info.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/store/remote_files.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The largest grid has 2^14 steps a side. On grids beyond 2^12 not every lattice resolution fits
// kMaxLatticeBits; requests for those that do not are refused.
inline constexpr std::int32_t kMaxGridExponent = 14;
static_assert(kMaxGridExponent + kDefaultLatticeResolution <= kMaxLatticeBits);
static_assert((std::int64_t{1} << kMaxGridExponent) + 1 == kMaxSide);

using DatasetPtr = std::shared_ptr<const PreparedVolume>;

// A file, or an address of one (http://, https://, s3://bucket/key); see prepared_file.hpp. Those
// that are opened with the same `files` share its caches and connections; without any, a small
// cache is made for this dataset alone. Damage that is found later throws DatasetFileError out of
// what reads the brick, failures of a store StoreError. Throws these.
[[nodiscard]] DatasetPtr open_dataset(const std::string& place,
                                      std::shared_ptr<RemoteFiles> files = nullptr);

// Whether a folder is meant, on this machine or in a bucket, whose files *.mtd are datasets.
[[nodiscard]] bool is_folder_of_datasets(const std::string& place);

// The files *.mtd in such a folder, by name; on this machine also those in its subfolders, but for
// hidden ones and links. Throws std::filesystem::filesystem_error, StoreError.
[[nodiscard]] std::vector<std::string> datasets_in(const std::string& folder);

// All samples in one piece, for the exact pass over a volume. Needs memory for them, and reads
// every brick.
[[nodiscard]] Volume whole_volume(const PreparedVolume& dataset);

}  // namespace multitetra
