#include "server/volume/formats/mgh_file.hpp"

#include <array>
#include <optional>
#include <string>

#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMghHeaderBytes = 284;

std::optional<StoredType> mgh_type(std::int32_t code) {
  constexpr std::array<std::pair<std::int32_t, StoredType>, 5> kTypes = {{{0, StoredType::kU8},
                                                                          {1, StoredType::kI32},
                                                                          {3, StoredType::kF32},
                                                                          {4, StoredType::kI16},
                                                                          {10, StoredType::kU16}}};
  for (const auto& [number, type] : kTypes) {
    if (number == code) return type;
  }
  return std::nullopt;
}

}  // namespace

bool is_mgh(std::string_view beginning) {
  if (beginning.size() < kMghHeaderBytes) return false;
  const HeaderBytes bytes(std::string(beginning.substr(0, kMghHeaderBytes)), Endian::kBig);
  const auto is_count = [&](std::size_t at) {
    return bytes.at<std::int32_t>(at) >= 1 && bytes.at<std::int32_t>(at) <= 1 << 20;
  };
  const auto good_axes = bytes.at<std::int16_t>(28);
  return bytes.at<std::int32_t>(0) == 1 && is_count(4) && is_count(8) && is_count(12) &&
         is_count(16) && mgh_type(bytes.at<std::int32_t>(20)).has_value() &&
         (good_axes == 0 || good_axes == 1);
}

StoredVolume open_mgh(const std::filesystem::path& path, const VolumeChoice& choice) {
  const std::string beginning = unpacked_beginning(InputFile(path), kMghHeaderBytes);
  if (!is_mgh(beginning)) {
    fail_reading(path, "it is not an MGH file", "Check its name and the program that wrote it");
  }
  const HeaderBytes bytes(beginning, Endian::kBig);
  const auto integer = [&](std::size_t at) { return std::int64_t{bytes.at<std::int32_t>(at)}; };
  const auto real = [&](std::size_t at) { return static_cast<double>(bytes.at<float>(at)); };
  ImageHeader header{.dims = {integer(4), integer(8), integer(12)},
                     .type = *mgh_type(bytes.at<std::int32_t>(20)),
                     .values = kNumbersAsStored,
                     .meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}}};
  // Voxel size, directions of the three axes, and center of the volume. Without them FreeSurfer
  // takes coronal slices of 1 mm.
  const bool has_geometry = bytes.at<std::int16_t>(28) == 1;
  std::array<Vec3, 3> steps = {Vec3{-1, 0, 0}, Vec3{0, 0, -1}, Vec3{0, 1, 0}};
  Vec3 origin{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; has_geometry && row < 3; ++row) {
      steps[axis][row] = real(42 + 12 * axis + 4 * row) * real(30 + 4 * axis);
    }
    if (has_geometry) origin[axis] += real(78 + 4 * axis);
    for (std::size_t row = 0; row < 3; ++row) {
      origin[row] -= steps[axis][row] * static_cast<double>(header.dims[axis]) / 2;
    }
  }
  ras_to_lps(header, steps, origin);
  set_axes(header, steps, stated(origin));
  if (!has_geometry) header.geometry.spacing = header.geometry.origin = kNotStated;
  check_header(path, header);
  const std::int64_t frames = integer(16);
  const std::int64_t frame = chosen_time(path, frames, choice);
  const std::uint64_t offset =
      kMghHeaderBytes + static_cast<std::uint64_t>(frame) * header.volume_bytes();
  VolumeContents contents;
  contents.times.count = frames;
  return {.header = header,
          .slices = slices_in_file(path, offset, Endian::kBig, header),
          .contents = std::move(contents)};
}

}  // namespace multitetra
