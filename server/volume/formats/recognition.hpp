// Recognizes the format of a file or folder by its content; its name decides only where its content
// cannot.
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
  kImageStack,  // A slice in each image.
  kVti,
  kPvti,
  kDicom,
  kZarr,  // OME-Zarr, Zarr and N5; also in a zip archive.
  kHdf5,
  kNetcdf3,
  kNpy,
  kMgh,
  kMrc,
  kCube,
  kRawDescription,  // A text that describes raw samples.
  kRaw,             // Raw samples, described elsewhere.
};

// nullopt when nothing that is known is there. Throws VolumeFileError when the file cannot be read.
[[nodiscard]] std::optional<VolumeFormat> recognized_format(const std::filesystem::path& path);

// For people: what each format is called, what it looks like, and what of it is read.
struct FormatDescription {
  std::string_view name;
  std::string_view files;
  std::string_view notes;
};
[[nodiscard]] std::span<const FormatDescription> known_formats();

}  // namespace multitetra
