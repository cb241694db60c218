// Structured points in legacy VTK files (.vtk).
#pragma once

#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Opens the array choice.array, text or binary, or else the first one, with a notice if there are
// several: SCALARS, VECTORS, NORMALS, TENSORS or those of a FIELD. Samples of CELL_DATA are at cell
// centers. A field TimeValue or TIME in front of them is the time. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_legacy_vtk(const std::filesystem::path& file,
                                           const VolumeChoice& choice);

}  // namespace multitetra
