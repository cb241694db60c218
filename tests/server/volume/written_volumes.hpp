// Volume files of every format as bytes, written without libraries, so that tests do not share a
// reader's interpretation of a format.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/volume/volume_files.hpp"

namespace multitetra {

// `values`, consecutively, as numbers of type Number.
template <typename Number>
std::string packed(const std::vector<double>& values, Endian endian = Endian::kLittle) {
  std::string bytes;
  for (const double value : values) {
    const auto number = static_cast<Number>(value);
    std::string one(reinterpret_cast<const char*>(&number), sizeof(number));
    if (endian == Endian::kBig) one.assign(one.rbegin(), one.rend());
    bytes += one;
  }
  return bytes;
}

// One deflated stream, zlib or gzip.
std::string deflated(std::string_view bytes, bool gzip);

// The content of all files below: 4 x 3 x 2 samples, value 10 * index + 7.
inline constexpr std::array<std::int32_t, 3> kDims = {4, 3, 2};
std::vector<double> values();

// An NRRD header with these lines, an empty line, and the samples.
std::string nrrd(std::string_view lines, std::string_view samples);

// A MetaImage header up to and including ElementDataFile.
std::string meta_image_header(std::string_view element_type, std::string_view data_file,
                              std::string_view more_lines = "");

// A NIfTI-1 file (.nii): spacing 1 2 3, first sample at (10, 20, 30) in RAS.
struct NiftiType {
  std::int16_t code;
  std::int16_t bits;
};
std::string nifti(NiftiType type, std::string_view samples, Endian endian,
                  std::array<float, 2> slope_and_intercept = {1, 0},
                  std::array<std::int16_t, 2> times_and_components = {1, 1});

// A legacy VTK file; `format` is ASCII or BINARY.
std::string legacy_vtk(std::string_view format, std::string_view type, std::string_view samples);

// Returns an uncompressed TIFF with one page of 4 x 3 unsigned samples for each of `pages`.
std::string tiff(const std::vector<std::string>& pages, int bytes_per_sample, int width = 4);

}  // namespace multitetra
