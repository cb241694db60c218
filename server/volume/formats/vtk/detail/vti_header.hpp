// Parses the XML of VTK image data (.vti) and polygons (.vtp): the arrays, and the locations of
// their bytes in the file.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/result.hpp"
#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct VtiArray {
  enum class Format { kText, kBase64, kAppended };
  std::string name;
  StoredType type = StoredType::kU8;
  std::int64_t components = 1;
  double slope = 1;  // Of the values; colors in text are shares of 255.
  Format format = Format::kText;
  bool of_cells = false;
  // The parent tag: "PointData", "Points", "Polys" and so on.
  std::string section;
  // Offsets of the bytes between the tags. For kAppended, `begin` is relative to the appended data
  // and `end` is unused.
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

enum class VtkDataKind { kImageData, kPolyData };

struct VtiHeader {
  // Extent of the samples: x0 x1 y0 y1 z0 z1, inclusive.
  std::array<std::int64_t, 6> extent{};
  // Extent of the samples in this file: a part, or all.
  std::array<std::int64_t, 6> piece{};
  std::optional<Vec3> origin = std::nullopt;
  std::optional<Vec3> spacing = std::nullopt;
  // Directions of the axes.
  std::array<Vec3, 3> directions = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  // For polygons: number of points.
  std::uint64_t points = 0;
  std::uint64_t polys = 0;
  std::uint64_t strips = 0;
  Endian endian = Endian::kLittle;
  int length_bytes = 4;    // Size of the numbers before the samples: 4 or 8.
  std::string compressor;  // Empty if uncompressed.
  std::string scalars;     // Name of the active point array; may be empty.
  std::string cell_scalars;
  std::vector<VtiArray> arrays;
  std::optional<VtiArray> time;           // The field data "TimeValue", a single number.
  bool appended_raw = false;              // Otherwise base64.
  std::optional<std::uint64_t> appended;  // Offset after the underscore.
};

// Returns the next bytes of the file; none at its end.
using NextBytes = std::function<std::string_view()>;

// The pieces listed by a .pvti file.
struct PvtiHeader {
  std::array<std::int64_t, 6> extent{};
  std::vector<std::string> pieces;  // Files of the pieces.
};
[[nodiscard]] Result<PvtiHeader> parse_pvti(std::string_view text);

// Returns kDamagedData or kInvalidArgument with a sentence unless it is readable data of `kind`.
[[nodiscard]] Result<VtiHeader> parse_vti(const NextBytes& next,
                                          VtkDataKind kind = VtkDataKind::kImageData);

}  // namespace multitetra
