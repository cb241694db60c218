// What tags of other programs in a TIFF directory state of its samples. Only tiff_pages.cpp
// includes it, as it includes libtiff.
#pragma once

#include <tiffio.h>

#include <cstdint>
#include <string>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/tiff_pages.hpp"

namespace multitetra {

// Returns a field of the current directory, or its default.
template <typename Value>
Value tiff_field(TIFF* tiff, std::uint32_t tag, Value otherwise) {
  Value value{};
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}

void add_metamorph(const InputFile& file, TIFF* tiff, TiffPages::Placement& placement);
void add_geotiff(TIFF* tiff, TiffPages::Placement& placement);
// Returns the program whose tags describe the image in a way that is not read; empty if none.
[[nodiscard]] std::string unread_convention(TIFF* tiff);
// Of GDAL's items, e.g. <Item name="SCALE" sample="0" role="scale">0.5</Item>.
[[nodiscard]] TiffPages::Scaling gdal_scaling(TIFF* tiff);
// MetaMorph's tag UIC2 has as many entries as the stack has images, of which the strips are the
// first; a directory with a depth has the images of a volume.
[[nodiscard]] std::int64_t images_in_directory(TIFF* tiff);

}  // namespace multitetra
