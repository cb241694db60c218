// The header of one frame of a DICOM file, without pixels. Only the dicom_ files include GDCM.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vec3.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace gdcm {
class PixelFormat;
}

namespace multitetra {

struct DicomImage {
  std::filesystem::path file;
  std::int64_t frame = 0;  // Index in the file.
  // Number of frames of the file.
  std::int64_t frames = 1;
  std::string series;
  std::string study;
  std::string patient;
  std::string description;
  std::string modality;
  std::string value_unit = {};
  bool is_localizer = false;
  bool has_excess_bytes = false;  // The file has more pixel data than its header announces.
  std::array<std::int64_t, 2> size = {1, 1};  // Columns and rows.
  StoredType type = StoredType::kU8;
  int components = 1;
  int stored_bits = 0;
  // Directions of increasing column and row number.
  Vec3 row{};
  Vec3 column{};
  double skew = 0;  // The cosine of the angle of both, as stored, where that was corrected.
  // Position of the first sample.
  Vec3 position{};
  bool has_position = false;
  bool has_own_place = false;  // The file gives each frame a position.
  Vec3 spacing = {1, 1, 1};
  double slope = 1;
  double intercept = 0;
  std::int64_t number = 0;  // Number in the series.
  double along = 0;         // Position along the normal of the plane.

  [[nodiscard]] std::size_t frame_bytes() const {
    return static_cast<std::size_t>(size[0] * size[1] * components) * bytes_of(type);
  }
};

// Returns nullopt for unsupported types.
[[nodiscard]] std::optional<StoredType> dicom_type(const gdcm::PixelFormat& format);

// Reads the frames of a file in order, each with its position, slope and intercept. Returns none
// for DICOM files without an image, such as reports and DICOMDIR. Throws VolumeFileError if the
// pixels are of an unsupported kind, or if the file is truncated: checks its length against rows,
// columns, frames and bits.
[[nodiscard]] std::vector<DicomImage> dicom_images(const std::filesystem::path& path);

}  // namespace multitetra
