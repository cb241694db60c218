// Volumes as NRRD files (http://teem.sourceforge.net/nrrd/format.html).
#pragma once

#include <filesystem>

#include "server/core/framework/volume.hpp"

namespace multitetra {

// Writes a NRRD (.nrrd) that read_volume reads back bit for bit. The file appears complete or not
// at all (see atomic_file.hpp). Throws VolumeFileError.
void write_nrrd(const std::filesystem::path& path, const Volume& volume);

}  // namespace multitetra
