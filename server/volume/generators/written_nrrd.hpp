// Volumes as NRRD files (http://teem.sourceforge.net/nrrd/format.html).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "server/volume/volume_source.hpp"

namespace multitetra {

// Writes a NRRD (.nrrd) that read_volume reads back bit for bit, slab by slab; reports written
// slices. The file appears complete or not at all (see atomic_file.hpp). Throws VolumeFileError.
void write_nrrd(const std::filesystem::path& path, VolumeSource& source,
                const std::function<void(std::int32_t slices)>& progress = {});

}  // namespace multitetra
