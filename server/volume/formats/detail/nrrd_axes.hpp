// The axes of a NRRD file: what they mean, and where they lie in the world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "common/image/nrrd_header.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The axes of a NRRD: up to three spatial ones, and one with times or components.
struct NrrdAxes {
  std::vector<std::size_t> space;
  std::optional<std::size_t> time;
  std::optional<std::size_t> component;
};

// Throws VolumeFileError unless the file contains one volume, or several along its first or last
// axis. With `has_components`, other axes than those of kind "time" are not times.
[[nodiscard]] NrrdAxes nrrd_axes(const std::filesystem::path& file, const NrrdHeader& header,
                                 const std::vector<std::int64_t>& sizes, bool has_components);

// Returns the `count` times along an axis.
[[nodiscard]] SourceTimes nrrd_times(const NrrdHeader& header, std::size_t axis,
                                     std::int64_t count);

// Places the image in the world; patient spaces become LPS. Throws VolumeFileError for an unknown
// space or invalid directions.
void place_nrrd(const std::filesystem::path& file, const NrrdHeader& header, const NrrdAxes& axes,
                const std::vector<std::int64_t>& sizes, ImageHeader& image);

}  // namespace multitetra
