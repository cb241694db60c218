// The pixel data of a DICOM file, as far as its completeness goes: GDCM fills up what is missing.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// The format of the pixel data by the header.
struct DicomPixels {
  // The offset of the value of the element (7FE0,0010) in the file.
  std::uint64_t offset = 0;
  std::string_view syntax = {};  // UID of the transfer syntax.
  std::uint64_t frames = 1;
  std::uint64_t frame_samples = 1;  // Pixels of a frame times samples of a pixel.
  std::uint64_t bits = 16;          // Allocated for a sample.
};

// Throws VolumeFileError where the pixel data are not all there: too short for the frames, behind
// the end of the file, or packed in fragments that end early. Returns whether there are more bytes
// than the header promises.
bool check_dicom_pixels(const InputFile& file, const DicomPixels& pixels);

// The same for files that are deflated as a whole (Deflated Explicit VR Little Endian): the stream
// must end well.
void check_deflated_dicom(const InputFile& file);

}  // namespace multitetra
