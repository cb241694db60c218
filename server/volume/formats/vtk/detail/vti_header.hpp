// The XML of VTK's files of image data (.vti) and of polygons (.vtp): what their arrays are, and
// where in the file their bytes are.
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
  Format format = Format::kText;
  bool of_cells = false;
  std::string section;      // The tag that it lies in: "PointData", "Points", "Polys" and so on.
  std::uint64_t begin = 0;  // The file's bytes between the tags; for kAppended begin is counted
  std::uint64_t end = 0;    // from the file's appended data on and end means nothing.
};

enum class VtkDataKind { kImageData, kPolyData };

struct VtiHeader {
  // The extent of the samples: x0 x1 y0 y1 z0 z1, both ends included.
  std::array<std::int64_t, 6> extent{};
  // The extent of the samples in the file: a part, or the same.
  std::array<std::int64_t, 6> piece{};
  Vec3 origin{};
  Vec3 spacing = {1, 1, 1};
  // The directions of the axes.
  std::array<Vec3, 3> directions = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  // For polygons: the number of points.
  std::uint64_t points = 0;
  std::uint64_t polys = 0;
  std::uint64_t strips = 0;
  Endian endian = Endian::kLittle;
  int length_bytes = 4;    // The size of the numbers before the samples: 4 or 8.
  std::string compressor;  // Empty: none.
  std::string scalars;     // The name of the active point array; may be empty.
  std::string cell_scalars;
  std::vector<VtiArray> arrays;
  bool appended_raw = false;              // Or base64.
  std::optional<std::uint64_t> appended;  // The file's offset behind the underscore.
};

// Gives the next bytes of the file; none at its end.
using NextBytes = std::function<std::string_view()>;

// The pieces that a .pvti file lists.
struct PvtiHeader {
  std::array<std::int64_t, 6> extent{};
  std::vector<std::string> pieces;  // The files that they lie in.
};
[[nodiscard]] Result<PvtiHeader> parse_pvti(std::string_view text);

// kDamagedData or kInvalidArgument with a sentence when it is no data of that kind that can be
// read.
[[nodiscard]] Result<VtiHeader> parse_vti(const NextBytes& next,
                                          VtkDataKind kind = VtkDataKind::kImageData);

}  // namespace multitetra
