// Places the frames of a DICOM file: by functional groups of enhanced files, the offsets of a dose
// grid, the slices of nuclear medicine, the tiles of a Siemens mosaic, or else one slice spacing
// apart.
#pragma once

#include <gdcmFile.h>

#include <string>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"

namespace multitetra {

// Returns the frames of a file with the header `whole`, whose position, directions and values it
// completes. Throws VolumeFileError.
[[nodiscard]] std::vector<DicomImage> frames_of_dicom(DicomImage whole, const gdcm::File& file);

// Sets slope and intercept, each of which the file may leave out (an empty list). A slope of 0
// would make all samples equal: then both are ignored.
void set_rescale(const std::vector<double>& slope, const std::vector<double>& intercept,
                 DicomImage& image);

// Returns the unit of values that have this rescale type.
[[nodiscard]] std::string dicom_value_unit(const std::string& rescale_type,
                                           const gdcm::DataSet& data, const std::string& modality);

}  // namespace multitetra
