// All formats of volume files, one registration each: everything that the engine knows about a
// format outside of its reader. A file or folder is recognized by its content, or by its name if
// that is inconclusive.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct VolumeFormat {
  // For users: what it is called, its files, and what is supported of it.
  std::string_view name;
  std::string_view files;
  std::string_view notes;
  // Throws VolumeFileError if the volume cannot be read.
  StoredVolume (*open)(const std::filesystem::path& path, const VolumeChoice& choice);
  // Returns whether a file with this beginning is of the format; null: not recognized by content.
  bool (*is_beginning)(std::string_view bytes) = nullptr;
  // Ends of names in lower case, separated by spaces: unknown content is read as this format, whose
  // reader then reports the error.
  std::string_view suffixes = {};
  bool has_arrays = false;    // Applies --array.
  bool has_levels = false;    // Applies --level.
  bool has_series = false;    // Applies --series.
  bool is_described = false;  // Other files may describe its samples.
};

// In the order of recognition.
[[nodiscard]] std::span<const VolumeFormat> volume_formats();

// Returns null for unknown formats. Throws VolumeFileError if the file cannot be read.
[[nodiscard]] const VolumeFormat* recognized_format(const std::filesystem::path& path);

// Returns the format of the numbered files that match a pattern such as "slice_###.tif".
[[nodiscard]] const VolumeFormat& format_of_pattern(const std::filesystem::path& pattern);

// Returns the format of arrays at addresses: http(s)://, s3://.
[[nodiscard]] const VolumeFormat& format_of_addresses();

}  // namespace multitetra
