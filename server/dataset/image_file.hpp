// One image file through ITK, which is seen by image_file.cpp and image_payload alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/core/framework/volume.hpp"
#include "server/dataset/formats/recognition.hpp"
#include "server/dataset/formats/stored_volume.hpp"

namespace multitetra {

struct PlainPayload;

class ImageFile {
 public:
  // Reads the header of a file of this format, one of kNrrd, kMetaImage, kLegacyVtk and kTiff. With
  // `follow` its data files may lie anywhere. Throws VolumeFileError when the header is damaged, or
  // it is no image of two or three dimensions (more may follow with one entry).
  ImageFile(const std::filesystem::path& file, VolumeFormat format, bool follow = false);
  ~ImageFile();
  ImageFile(ImageFile&&) noexcept;

  [[nodiscard]] const ImageHeader& header() const { return header_; }

  // Where the samples are when they lie in files as they are; nullopt when they must be read
  // through read(). Requires dims within the largest grid. Throws VolumeFileError.
  [[nodiscard]] std::optional<PlainPayload> plain_payload() const;

  // All samples into `memory`, x fastest, in the byte order of this machine. Throws
  // VolumeFileError, also when the file holds less than its header promises.
  void read(void* memory) const;

 private:
  struct Reader;
  std::filesystem::path file_;
  ImageHeader header_;
  std::unique_ptr<Reader> reader_;
};

}  // namespace multitetra
