// Recognizes the format of a file or folder by its content, or by its name if that is inconclusive.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

namespace multitetra {

enum class VolumeFormat {
  kNrrd,
  kMetaImage,
  kNifti,
  kLegacyVtk,
  kTiff,
  kImageStack,  // An image per slice.
  kVti,
  kPvti,
  kDicom,
  kZarr,  // OME-Zarr, Zarr and N5; also in a zip archive.
  kHdf5,
  kNetcdf,
  kNpy,
  kMgh,
  kMrc,
  kCube,
  kRawDescription,  // A text file that describes raw samples.
  kRaw,             // Raw samples, described elsewhere.
};

// Returns nullopt for unknown formats. Throws VolumeFileError if the file cannot be read.
[[nodiscard]] std::optional<VolumeFormat> recognized_format(const std::filesystem::path& path);

// Describes a format to users: its name, its files, and what is supported.
struct FormatDescription {
  std::string_view name;
  std::string_view files;
  std::string_view notes;
};
[[nodiscard]] std::span<const FormatDescription> known_formats();

}  // namespace multitetra
