// The beginning of a DICOM file and whether it is complete: GDCM aborts on files that end early.
#pragma once

#include <cstdint>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// Returns the offset behind the meta information (group 2; DICOM PS3.10, section 7.1), which is
// where the data set begins. Throws VolumeFileError for a file that ends within or with it.
[[nodiscard]] std::uint64_t dicom_meta_end(const InputFile& file);

// Throws VolumeFileError for a file that ends within an element before its pixels. Leaves to GDCM
// what follows an element that contradicts its predecessors.
void check_dicom_elements(const InputFile& file, std::uint64_t meta_end);

}  // namespace multitetra
