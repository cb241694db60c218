// Checks that the pixel data of a DICOM file are complete, since GDCM fills in missing data.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// The format of the pixel data according to the header.
struct DicomPixels {
  // Offset in the file of the value of element (7FE0,0010).
  std::uint64_t offset = 0;
  std::string_view syntax = {};  // Transfer syntax UID.
  std::uint64_t frames = 1;
  std::uint64_t frame_samples = 1;  // Pixels per frame times samples per pixel.
  std::uint64_t bits = 16;          // Allocated per sample.
};

// Throws VolumeFileError if pixel data are missing: too few bytes for the frames, an end beyond
// that of the file, or truncated fragments. Returns whether there are more bytes than announced.
bool check_dicom_pixels(const InputFile& file, const DicomPixels& pixels);

// Checks a file that is deflated as a whole (Deflated Explicit VR Little Endian).
void check_deflated_dicom(const InputFile& file);

}  // namespace multitetra
