// A prepared dataset: a volume with its metadata and its errors for every isovalue. Immutable; all
// sessions share it by pointer to const.
//
//   const DatasetPtr head = open_dataset("head.mtd");
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/lattice.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/store/remote_files.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The largest grid has 2^14 steps per side. Beyond 2^12 the finest lattice resolutions exceed
// kMaxLatticeBits; requests for them are refused.
inline constexpr std::int32_t kMaxGridExponent = 14;
static_assert(kMaxGridExponent + kDefaultLatticeResolution <= kMaxLatticeBits);
static_assert((std::int64_t{1} << kMaxGridExponent) + 1 == kMaxSide);

class PreparedFile;
using DatasetPtr = std::shared_ptr<const PreparedVolume>;

// Opens a file or an address (http://, https://, s3://bucket/key); see prepared_file.hpp. Datasets
// opened with the same `files` share its caches and connections; without it, the dataset gets a
// small cache of its own. Throws DatasetFileError or StoreError; reading a brick later throws them
// too, for damage or a failing store.
[[nodiscard]] DatasetPtr open_dataset(const std::string& place,
                                      std::shared_ptr<RemoteFiles> files = nullptr);
[[nodiscard]] DatasetPtr dataset_in(const PreparedFile& file, const std::string& place);

// Returns whether `place` is a folder of *.mtd files, on this machine or in a bucket.
[[nodiscard]] bool is_folder_of_datasets(const std::string& place);

// Returns the *.mtd files of such a folder, sorted by name. Includes local subfolders, except
// hidden ones and links. Throws std::filesystem::filesystem_error or StoreError.
[[nodiscard]] std::vector<std::string> datasets_in(const std::string& folder);

// Reads all samples into memory, for the exact pass over a volume.
[[nodiscard]] Volume whole_volume(const PreparedVolume& dataset);

}  // namespace multitetra
