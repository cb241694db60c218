// The files of a zip archive as a store: an OME-Zarr or Zarr in one file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "server/store/object_store.hpp"
#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Returns whether a file with this beginning is a zip archive.
[[nodiscard]] bool is_zip(std::string_view beginning);

// Keys are relative to the outermost folder with Zarr or N5 metadata. Supports stored and deflated
// entries; checks the CRC of those that are read whole. Throws VolumeFileError unless the archive
// is complete; the store's functions throw it for damaged entries.
[[nodiscard]] std::unique_ptr<ObjectStore> zip_store(const std::filesystem::path& file);

// Returns the slices of `header` that start at `offset` in a file inside an archive. Going back in
// a deflated one starts over. Throws VolumeFileError if there is no such file, or it is too short.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_in_zip(const std::filesystem::path& file,
                                                          const std::string& name,
                                                          std::uint64_t offset, Endian endian,
                                                          const ImageHeader& header);

}  // namespace multitetra
