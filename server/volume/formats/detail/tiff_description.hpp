// Parses the descriptions that programs write to TIFF files: the slice, channel and time of each
// page, and the spacing of samples.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

// A channel's name and display settings, written by a microscope.
struct TiffChannel {
  std::string name = {};                              // May be empty.
  std::optional<std::uint32_t> color = std::nullopt;  // 0xRRGGBB.
};

struct TiffDescription {
  std::int64_t slices = 1;
  std::int64_t channels = 1;
  SourceTimes times = {};
  std::array<std::optional<double>, 3> spacing = {};  // Along x, y, z, if given.
  std::array<std::string, 3> units = {};              // Of the axes; empty if unknown.
  // The resolution counts pixels per unit.
  bool resolution_is_spacing = false;
  // The sample at the world's origin, counted in samples along x, y, z.
  std::optional<Vec3> origin_sample = std::nullopt;
  // value = slope * stored + intercept, in this unit.
  std::optional<double> slope = std::nullopt;
  double intercept = 0;
  std::string value_unit = {};
  // The function of a calibration that is not a line; empty if there is none.
  std::string unread_function = {};
  std::vector<TiffChannel> described_channels = {};  // Empty, or one per channel.
  // Slice z, channel c and time t are page pages[(t * channels + c) * slices + z].
  std::vector<std::size_t> pages = {};
  // The names of the files that pages are in, of which the empty one is that of the description,
  // and the file of each page. Both are empty if all are in one file.
  std::vector<std::string> files = {};
  std::vector<std::size_t> file_of_page = {};
  // The names of all images that the description has, of which this is the one numbered `image`.
  std::vector<std::string> images = {};
  std::size_t image = 0;
};

// Parses the description of an ImageJ hyperstack ("ImageJ=1.53..."). The file may have fewer pages:
// stacks beyond 4 GiB have one page, followed by all samples.
[[nodiscard]] Result<TiffDescription> parse_imagej_description(std::string_view text);

// Returns whether a file with this beginning is a document of OME, as beside the TIFF files of a
// set.
[[nodiscard]] bool is_ome_xml(std::string_view beginning);

// Where other files of a set are, by the XML document of one.
struct OmeSet {
  std::string metadata_file = {};  // The file with the description, if it is another.
  std::string first_file = {};     // The first file that has pages; empty if none is named.
};
[[nodiscard]] OmeSet parse_ome_set(std::string_view text);

// Parses the XML document of OME-TIFF. `components` is the number of components per sample. Several
// images are counted from 1; `wanted` is a number, an ID or a name, or empty for the first.
[[nodiscard]] Result<TiffDescription> parse_ome_description(std::string_view text,
                                                            std::int64_t components,
                                                            std::string_view wanted = {});

// Parses the shape that tifffile writes: {"shape": [5, 6, 8]}, slowest first, with `components`
// last, or before rows and columns, if there are several. The slices come last; axes before them
// are times, unless "axes" names them C. Returns nothing for other text, or if an image has another
// size (columns and rows).
[[nodiscard]] std::optional<TiffDescription> parse_shape(std::string_view text,
                                                         std::array<std::int64_t, 2> image_size,
                                                         std::int64_t components);

}  // namespace multitetra
