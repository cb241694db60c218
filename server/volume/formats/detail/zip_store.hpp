// The files in a zip archive as a store: an OME-Zarr or Zarr in one file.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "server/store/object_store.hpp"

namespace multitetra {

// Whether a file that begins so is a zip archive.
[[nodiscard]] bool is_zip(std::string_view beginning);

// Keys begin at the outermost folder that has metadata of Zarr or N5. Entries are stored or
// deflated; those that are read as a whole have their CRC compared. Throws VolumeFileError when it
// is no whole archive; the store's functions throw VolumeFileError where an entry is damaged.
[[nodiscard]] std::unique_ptr<ObjectStore> zip_store(const std::filesystem::path& file);

}  // namespace multitetra
