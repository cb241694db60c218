// One file of DICOM images, without its pixels: what its header says. GDCM's types are seen here
// and in dicom_series.cpp alone.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/base/vec3.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace gdcm {
class PixelFormat;
}

namespace multitetra {

struct DicomImage {
  std::filesystem::path file;
  std::string series;
  std::string description;
  std::string modality;
  std::string value_unit = {};
  std::array<std::int64_t, 3> dims = {1, 1, 1};
  StoredType type = StoredType::kU8;
  int components = 1;
  int stored_bits = 0;
  Vec3 row{};  // Of the image plane: the direction in which columns are counted.
  Vec3 column{};
  Vec3 position{};  // Of the first sample.
  bool has_position = false;
  Vec3 spacing = {1, 1, 1};
  double slope = 1;
  double intercept = 0;
  std::int64_t number = 0;  // In the series.
  double along = 0;         // Its place along the normal of the plane.
};

// nullopt for types that no volume has.
[[nodiscard]] std::optional<StoredType> dicom_type(const gdcm::PixelFormat& format);

// What the header says. nullopt for DICOM files without an image, such as reports and DICOMDIR.
// Throws VolumeFileError where the pixels are of a type or kind that no volume has.
[[nodiscard]] std::optional<DicomImage> dicom_image(const std::filesystem::path& path);

}  // namespace multitetra
