// The pixels of the frames of DICOM files, decompressed by GDCM or read from the file as they are.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"

namespace multitetra {

class DicomFrames {
 public:
  // Returns the samples of a frame, image.frame_bytes() bytes of image.type, valid until the next
  // call. Bits of binary segmentations become 0 or 1. Keeps the frames of one file in memory,
  // unless they can be read one by one. Throws VolumeFileError.
  [[nodiscard]] std::span<const std::byte> samples(const DicomImage& image);

 private:
  void load(const DicomImage& image);
  void load_by_gdcm(const DicomImage& image);
  void load_element(const DicomImage& image);
  [[nodiscard]] std::span<const std::byte> unpacked_bits(std::span<const std::byte> bytes,
                                                         std::size_t first_bit, std::size_t count);
  [[nodiscard]] std::span<const std::byte> tile_of_mosaic(const DicomImage& image);

  std::filesystem::path loaded_;   // The file of pixels_; empty if there is none.
  std::vector<std::byte> pixels_;  // All frames of that file.
  std::vector<std::byte> one_;     // The last frame that is not in pixels_.
};

}  // namespace multitetra
