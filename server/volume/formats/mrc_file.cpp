#include "server/volume/formats/mrc_file.hpp"

#include <array>
#include <cmath>
#include <string>

#include "server/volume/formats/detail/contour_level.hpp"
#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMrcHeaderBytes = 1024;
constexpr std::int32_t kHalfMode = 12;  // 16-bit floats.

StoredType type_of_mode(const fs::path& file, std::int32_t mode) {
  if (mode == 0) return StoredType::kI8;
  if (mode == 1) return StoredType::kI16;
  if (mode == 2) return StoredType::kF32;
  if (mode == 6) return StoredType::kU16;
  if (mode == kHalfMode) return StoredType::kF32;
  fail_reading(file, "its mode is " + std::to_string(mode),
               "Supported modes are 0, 1, 2, 6 and 12; save it as mode 2");
}

}  // namespace

bool is_mrc(std::string_view beginning) {
  return beginning.size() >= 212 && beginning.substr(208, 4) == "MAP ";
}

StoredVolume open_mrc(const fs::path& path) {
  const std::string beginning = unpacked_beginning(InputFile(path), kMrcHeaderBytes);
  if (beginning.size() < kMrcHeaderBytes) fail_damaged(path, "it ends within its header");
  const bool big = beginning[212] == 0x11;
  const Endian endian = big ? Endian::kBig : Endian::kLittle;
  const HeaderBytes bytes(beginning, endian);
  const auto integer = [&](std::size_t at) { return bytes.at<std::int32_t>(at); };
  const auto real = [&](std::size_t at) { return static_cast<double>(bytes.at<float>(at)); };

  ImageHeader header{.type = type_of_mode(path, integer(12)),
                     .meaning = {.length_unit = "Å", .value_unit = {}}};
  // MAPC, MAPR, MAPS: the axis of the cell, 1 to 3, of columns, rows and sections.
  std::array<std::size_t, 3> cell_axis{};
  int seen = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.dims[axis] = integer(4 * axis);
    const std::int32_t along = integer(64 + 4 * axis);
    cell_axis[axis] = along >= 1 && along <= 3 ? static_cast<std::size_t>(along - 1) : axis;
    seen |= 1 << cell_axis[axis];
    const double angle = real(52 + 4 * axis);
    if (angle == 90 || angle == 0) continue;
    fail_reading(path, "the angles of its cell are not 90 degrees",
                 "Resample it onto a rectangular grid");
  }
  if (seen != 7) fail_damaged(path, "two of its axes have the same direction");
  std::array<Vec3, 3> steps{};
  Vec3 origin = {real(196), real(200), real(204)};
  const bool has_origin = origin != Vec3{0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t along = cell_axis[axis];
    const std::int32_t intervals = integer(28 + 4 * along);
    const double length = real(40 + 4 * along);
    const double step = intervals > 0 && length > 0 ? length / intervals : 0;
    steps[axis][along] = step;
    if (!has_origin) origin[along] = step * integer(16 + 4 * axis);
  }
  set_axes(header, steps, stated(origin));
  check_header(path, header);
  const std::int32_t extended = integer(92);
  if (extended < 0) fail_damaged(path, "its extended header has a negative length");
  const std::uint64_t offset = kMrcHeaderBytes + static_cast<std::uint64_t>(extended);
  StoredVolume volume;
  volume.header = header;
  volume.contents.recommended_isovalue = sidecar_contour_level(path);
  volume.slices = integer(12) == kHalfMode ? halves_in_file(path, offset, endian, header)
                                           : slices_in_file(path, offset, endian, header);
  return volume;
}

}  // namespace multitetra
