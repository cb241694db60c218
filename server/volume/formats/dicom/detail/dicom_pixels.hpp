// Checks that the pixel data of a DICOM file are complete, since GDCM fills in missing data.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// The format of the pixel data according to the header.
struct DicomPixels {
  std::uint16_t element = 0x0010;  // Of group 7FE0.
  std::uint64_t offset = 0;        // Of the value of that element in the file.
  std::string_view syntax = {};    // Transfer syntax UID.
  std::uint64_t frames = 1;
  std::uint64_t frame_samples = 1;  // Pixels per frame times samples per pixel.
  std::uint64_t bits = 16;          // Allocated per sample.
};

// Throws VolumeFileError if pixel data are missing: too few bytes for the frames, an end beyond
// that of the file, or truncated fragments. Returns whether there are more bytes than announced.
bool check_dicom_pixels(const InputFile& file, const DicomPixels& pixels);

// Returns whether the value of the element (7FE0,element) begins at `offset`.
[[nodiscard]] bool has_pixels_before(const InputFile& file, std::uint64_t offset,
                                     std::uint16_t element);

}  // namespace multitetra
