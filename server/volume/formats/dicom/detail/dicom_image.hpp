// The header of one frame of a DICOM file, without pixels. Only files of this folder include GDCM.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vec3.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace gdcm {
class PixelFormat;
}

namespace multitetra {

// The part of a Siemens mosaic that is one slice.
struct DicomTile {
  std::int64_t mosaic_columns = 1;
  std::int64_t mosaic_rows = 1;
  std::int64_t first_column = 0;
  std::int64_t first_row = 0;
};

// DICOM SEG: what the samples of a frame mean. Fractional ones are shares of a maximum.
enum class Segmentation { kNone, kBinary, kFractional, kLabelMap };

// Where a distance between samples comes from.
enum class SpacingSource {
  kNone,            // The header does not state it; 1 mm is used.
  kStated,          // PixelSpacing, positions, or spacing between slices as the standard has it.
  kAtDetector,      // ImagerPixelSpacing: larger than in the patient.
  kScannedFilm,     // NominalScannedPixelSpacing.
  kBetweenSlices,   // SpacingBetweenSlices of slices without positions.
  kSliceThickness,  // SliceThickness of slices without positions.
};

// Numbers of elements that tell images at one position apart (dicom_moments.hpp).
inline constexpr std::size_t kDicomMoments = 10;
inline constexpr std::array<double, kDicomMoments> kNoMoment = [] {
  std::array<double, kDicomMoments> none{};
  none.fill(-std::numeric_limits<double>::infinity());
  return none;
}();

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
  std::string refusal = {};  // Why the file cannot be read; what follows may be unset then.
  std::string value_unit = {};
  bool is_localizer = false;
  bool is_projection = false;     // A frame of nuclear medicine that is no slice.
  bool has_excess_bytes = false;  // The file has more pixel data than its header announces.
  std::array<std::int64_t, 2> size = {1, 1};  // Columns and rows.
  StoredType type = StoredType::kU8;
  int components = 1;
  bool is_ybr = false;      // Components are luminance and two color differences.
  bool has_planes = false;  // Components are stored one after the other, but for JPEG.
  int stored_bits = 0;
  int unused_bits = 0;  // Below those of a sample: HighBit + 1 - BitsStored.
  // Directions of increasing column and row number.
  Vec3 row{};
  Vec3 column{};
  double skew = 0;  // The cosine of the angle of both, as stored, where that was corrected.
  // Position of the first sample.
  Vec3 position{};
  bool has_position = false;
  bool has_origin = false;                             // The file states a position, of any frame.
  bool has_orientation = false;                        // The file states row and column.
  bool has_own_place = false;                          // The file gives each frame a position.
  bool is_in_own_space = false;                        // Positions are not those of a patient.
  Vec3 spacing = {1, 1, 1};                            // Columns, rows and slices apart; > 0.
  SpacingSource plane_spacing = SpacingSource::kNone;  // Of columns and rows.
  SpacingSource slice_spacing = SpacingSource::kNone;
  std::string region_notice = {};  // Why regions of an ultrasound image give it no spacing.
  bool is_cine = false;            // Frames follow each other in time.
  bool has_sign = true;            // The file states whether integers are signed.
  bool has_rescale = false;        // The file states slope or intercept.
  std::string mapping_notice =
      {};  // What of the file's ways from numbers to values is not applied.
  // The least and the largest number that fill samples outside of the image (PixelPaddingValue).
  std::optional<std::array<double, 2>> padding = std::nullopt;
  double slope = 1;
  double intercept = 0;
  std::int64_t number = 0;  // Number in the series.
  double along = 0;         // Position along the normal of the plane.
  std::array<double, kDicomMoments> moment = kNoMoment;

  // ---- pixels
  std::uint16_t element = 0x0010;  // Of group 7FE0; 0x0008 has floats, 0x0009 doubles.
  // Where the pixels begin, if frames can be read from the file as they are.
  std::optional<std::uint64_t> pixels_at = std::nullopt;
  bool is_jpeg = false;  // Compressed by a kind of JPEG.
  std::optional<DicomTile> tile = std::nullopt;

  // ---- segmentations
  Segmentation segmentation = Segmentation::kNone;
  bool has_bits = false;           // Samples are stored as bits.
  std::int64_t segment = 0;        // Number of the segment in this frame.
  std::int64_t largest_share = 1;  // The sample that means all of a fractional segment.

  [[nodiscard]] std::size_t frame_bytes() const {
    return static_cast<std::size_t>(size[0] * size[1] * components) * bytes_of(type);
  }
  // Returns the bytes of all frames of the file, unpacked.
  [[nodiscard]] std::size_t file_bytes() const {
    if (!tile) return static_cast<std::size_t>(frames) * frame_bytes();
    return static_cast<std::size_t>(tile->mosaic_columns * tile->mosaic_rows * components) *
           bytes_of(type);
  }
};

// Returns nullopt for unsupported types.
[[nodiscard]] std::optional<StoredType> dicom_type(const gdcm::PixelFormat& format);

// Reads the frames of a file in order, each with its position, slope and intercept; the slices of a
// Siemens mosaic are frames. Returns none for DICOM files without an image, such as reports and
// DICOMDIR, and one with a refusal if the pixels are of an unsupported kind, or if the file is
// truncated: checks its length against rows, columns, frames and bits. Throws VolumeFileError if
// the series of such a file is unknown.
[[nodiscard]] std::vector<DicomImage> dicom_images(const std::filesystem::path& path);

// Returns the segments that a segmentation declares, with their names and colors. Their layers are
// 0. Skips invalid ones.
[[nodiscard]] std::vector<SourceLabel> dicom_segments(const std::filesystem::path& path);

}  // namespace multitetra
