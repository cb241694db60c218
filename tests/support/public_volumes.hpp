// Reads the public volumes that have reference numbers as raw bytes, from the folder named by
// MULTITETRA_PUBLIC_DATA. They are not part of the project; tests skip if they are absent.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "server/core/framework/volume.hpp"

namespace multitetra::testing {

inline std::filesystem::path public_data(const std::string& file) {
  return std::filesystem::path(MULTITETRA_PUBLIC_DATA) / file;
}

// Appends `count` samples from the file after `header_bytes`; returns false if there is no such
// file or it is too short.
template <typename Sample>
bool append_raw(const std::filesystem::path& path, std::size_t header_bytes, std::size_t count,
                std::vector<Sample>& samples) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header_bytes));
  const std::size_t before = samples.size();
  samples.resize(before + count);
  const auto bytes = static_cast<std::streamsize>(count * sizeof(Sample));
  return static_cast<bool>(file.read(reinterpret_cast<char*>(samples.data() + before), bytes));
}

inline Volume volume_of(std::array<std::int32_t, 3> dims, Samples samples,
                        Vec3 spacing = {1, 1, 1}) {
  Volume volume{
      .dims = dims, .spacing = spacing, .index_to_world = {}, .samples = std::move(samples)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    volume.index_to_world.columns[axis][axis] = spacing[axis];
  return volume;
}

template <typename Sample>
std::optional<Volume> raw_volume(const std::string& file, std::size_t header_bytes,
                                 std::array<std::int32_t, 3> dims) {
  std::vector<Sample> samples;
  const auto count = static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) *
                     static_cast<std::size_t>(dims[2]);
  if (!append_raw(public_data(file), header_bytes, count, samples)) return std::nullopt;
  return volume_of(dims, std::move(samples));
}

inline std::optional<Volume> ct_head() {
  return raw_volume<std::uint16_t>("head_128x128x112.dat", 6, {128, 128, 112});
}
inline std::optional<Volume> fuel() {
  return raw_volume<std::uint8_t>("fuel_64x64x64_uint8.raw", 0, {64, 64, 64});
}
inline std::optional<Volume> neghip() {
  return raw_volume<std::uint8_t>("neghip_64x64x64_uint8.raw", 0, {64, 64, 64});
}
inline std::optional<Volume> tooth() {
  return raw_volume<std::uint8_t>("tooth_103x94x161_uint8.raw", 0, {103, 94, 161});
}
inline std::optional<Volume> headsq() {
  std::vector<std::int16_t> samples;
  for (int slice = 1; slice <= 93; ++slice) {
    if (!append_raw(public_data("headsq/quarter." + std::to_string(slice)), 0, 64 * 64, samples)) {
      return std::nullopt;
    }
  }
  return volume_of({64, 64, 93}, std::move(samples), {3.2, 3.2, 1.5});
}

}  // namespace multitetra::testing
