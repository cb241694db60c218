// The header of one frame of a DICOM file, without its pixels. Only the dicom_ files include GDCM.
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
  std::int64_t frame = 0;  // In the file, from 0 on.
  // The number of frames of the file.
  std::int64_t frames = 1;
  std::string series;
  std::string study;
  std::string patient;
  std::string description;
  std::string modality;
  std::string value_unit = {};
  bool is_localizer = false;
  bool has_excess_bytes = false;  // The file has more pixel data than its header promises.
  std::array<std::int64_t, 2> size = {1, 1};  // Columns and rows.
  StoredType type = StoredType::kU8;
  int components = 1;
  int stored_bits = 0;
  // The direction of the image plane in which columns are counted.
  Vec3 row{};
  Vec3 column{};
  // The position of the first sample.
  Vec3 position{};
  bool has_position = false;
  bool has_own_place = false;  // The file gives each frame a position.
  Vec3 spacing = {1, 1, 1};
  double slope = 1;
  double intercept = 0;
  std::int64_t number = 0;  // In the series.
  double along = 0;         // Its place along the normal of the plane.

  [[nodiscard]] std::size_t frame_bytes() const {
    return static_cast<std::size_t>(size[0] * size[1] * components) * bytes_of(type);
  }
};

// nullopt for types that no volume has.
[[nodiscard]] std::optional<StoredType> dicom_type(const gdcm::PixelFormat& format);

// The frames of a file, in its order, each with the place, slope and intercept that the file gives
// it. Empty for DICOM files without an image, such as reports and DICOMDIR. Throws VolumeFileError
// where the pixels are of a type or kind that no volume has, and where the file is cut off: its
// length is compared with its rows, columns, frames and bits.
[[nodiscard]] std::vector<DicomImage> dicom_images(const std::filesystem::path& path);

}  // namespace multitetra
