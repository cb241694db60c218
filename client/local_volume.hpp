// A local copy of a dataset's volume, to check a server's surfaces against.
#pragma once

#include <filesystem>
#include <vector>

#include "common/request/dataset_info.hpp"

namespace multitetra {

// The samples of the volume in `file`, x fastest, NaN where there is no field (infinite values are
// none either), as many as the dataset's dims say. Formats by suffix: .nrrd .nhdr .mha .mhd .nii
// .nii.gz .vtk .tif .tiff; any other file is taken for raw samples of the dataset's dims and type
// at the file's end, of whichever byte order fits. Some NRRD headers that the server repairs are
// refused by ITK, and so here.
//
// Throws std::runtime_error, which names the file and the difference, unless its dims, its spacing
// (raw: none) and the range of its values are the dataset's.
[[nodiscard]] std::vector<float> read_local_volume(const std::filesystem::path& file,
                                                   const DatasetInfo& info);

}  // namespace multitetra
