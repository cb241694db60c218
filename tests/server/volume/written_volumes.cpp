#include "tests/server/volume/written_volumes.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstddef>

namespace multitetra {
namespace {

template <typename Number>
void put(std::string& bytes, std::size_t offset, double value, Endian endian) {
  bytes.replace(offset, sizeof(Number), packed<Number>({value}, endian));
}

// One 12-byte entry of a TIFF directory with a single value.
std::string tiff_entry(double tag, bool is_long, double value) {
  std::string entry = packed<std::uint16_t>({tag, is_long ? 4.0 : 3.0});
  entry += packed<std::uint32_t>({1});
  entry += is_long ? packed<std::uint32_t>({value}) : packed<std::uint16_t>({value, 0});
  return entry;
}

}  // namespace

std::string deflated(std::string_view bytes, bool gzip) {
  z_stream stream = {};
  deflateInit2(&stream, 6, Z_DEFLATED, gzip ? 15 + 16 : 15, 8, Z_DEFAULT_STRATEGY);
  std::string input(bytes);
  std::string output(bytes.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<unsigned char*>(input.data());
  stream.avail_in = static_cast<unsigned>(input.size());
  stream.next_out = reinterpret_cast<unsigned char*>(output.data());
  stream.avail_out = static_cast<unsigned>(output.size());
  deflate(&stream, Z_FINISH);
  output.resize(stream.total_out);
  deflateEnd(&stream);
  return output;
}

std::vector<double> values() {
  std::vector<double> result;
  for (int i = 0; i < kDims[0] * kDims[1] * kDims[2]; ++i) result.push_back(10 * i + 7);
  return result;
}

std::string nrrd(std::string_view lines, std::string_view samples) {
  return "NRRD0004\n" + std::string(lines) + "\n" + std::string(samples);
}

std::string meta_image_header(std::string_view element_type, std::string_view data_file,
                              std::string_view more_lines) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" +
         std::string(more_lines) +
         "Offset = 10 20 30\nElementSpacing = 1 2 3\nDimSize = 4 3 2\nElementType = " +
         std::string(element_type) + "\nElementDataFile = " + std::string(data_file) + "\n";
}

std::string nifti(NiftiType type, std::string_view samples, Endian endian,
                  std::array<float, 2> slope_and_intercept,
                  std::array<std::int16_t, 2> times_and_components) {
  std::string bytes(352, '\0');
  const auto put_short = [&](std::size_t at, double value) {
    put<std::int16_t>(bytes, at, value, endian);
  };
  const auto put_float = [&](std::size_t at, double value) {
    put<float>(bytes, at, value, endian);
  };
  put<std::int32_t>(bytes, 0, 348, endian);
  const auto [times, components] = times_and_components;
  const std::vector<double> dim = {components > 1 ? 5.0
                                   : times > 1    ? 4.0
                                                  : 3.0,
                                   4,
                                   3,
                                   2,
                                   static_cast<double>(times),
                                   static_cast<double>(components),
                                   1,
                                   1};
  for (std::size_t i = 0; i < dim.size(); ++i) put_short(40 + 2 * i, dim[i]);
  if (components > 1) put_short(68, 1007);  // NIFTI_INTENT_VECTOR
  put_short(70, type.code);
  put_short(72, type.bits);
  const std::vector<double> pixdim = {1, 1, 2, 3, 1, 1, 1, 1};
  for (std::size_t i = 0; i < pixdim.size(); ++i) put_float(76 + 4 * i, pixdim[i]);
  put_float(108, 352);
  put_float(112, static_cast<double>(slope_and_intercept[0]));
  put_float(116, static_cast<double>(slope_and_intercept[1]));
  put_short(252, 1);  // qform: the identity rotation and an offset.
  put_float(268, 10);
  put_float(272, 20);
  put_float(276, 30);
  bytes.replace(344, 3, "n+1");
  return bytes + std::string(samples);
}

std::string legacy_vtk(std::string_view format, std::string_view type, std::string_view samples) {
  return "# vtk DataFile Version 3.0\nwritten by a test\n" + std::string(format) +
         "\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 2 3\nORIGIN 10 20 30\n"
         "POINT_DATA 24\nSCALARS scalars " +
         std::string(type) + " 1\nLOOKUP_TABLE default\n" + std::string(samples);
}

std::string tiff(const std::vector<std::string>& pages, int bytes_per_sample, int width) {
  constexpr double kEntries = 9;
  constexpr std::size_t kDirectoryBytes = 2 + 12 * 9 + 4;
  std::string bytes = "II" + packed<std::uint16_t>({42}) + packed<std::uint32_t>({8});
  for (std::size_t page = 0; page < pages.size(); ++page) {
    const std::size_t strip = bytes.size() + kDirectoryBytes;
    const std::size_t next = page + 1 < pages.size() ? strip + pages[page].size() : 0;
    bytes += packed<std::uint16_t>({kEntries});
    bytes += tiff_entry(256, true, width);
    bytes += tiff_entry(257, true, 3);
    bytes += tiff_entry(258, false, 8 * bytes_per_sample);
    bytes += tiff_entry(259, false, 1);  // No compression.
    bytes += tiff_entry(262, false, 1);  // Black is zero.
    bytes += tiff_entry(273, true, static_cast<double>(strip));
    bytes += tiff_entry(277, false, 1);  // Samples per pixel.
    bytes += tiff_entry(278, true, 3);   // Rows per strip.
    bytes += tiff_entry(279, true, static_cast<double>(pages[page].size()));
    bytes += packed<std::uint32_t>({static_cast<double>(next)});
    bytes += pages[page];
  }
  return bytes;
}

}  // namespace multitetra
