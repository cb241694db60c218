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

// Which of the volumes that follow each other in a file.
struct VolumeInFile {
  std::int64_t index = 0;
  std::int64_t count = 1;
};

class ImageFile {
 public:
  // Reads the header of a file of this format, one of kNrrd, kMetaImage, kLegacyVtk and kTiff. Of
  // several volumes along a fourth dimension it is the one that choice.time names. Throws
  // VolumeFileError when the header is damaged, or it is no image of two or three dimensions (more
  // may follow with one entry), or a time must be chosen.
  ImageFile(const std::filesystem::path& file, VolumeFormat format,
            const VolumeChoice& choice = {});
  ~ImageFile();
  ImageFile(ImageFile&&) noexcept;

  [[nodiscard]] const ImageHeader& header() const { return header_; }
  [[nodiscard]] const SourceMembers& members() const { return members_; }
  // Where a sample has a number for each time: that of the chosen time.
  [[nodiscard]] std::optional<int> component_of_time() const { return component_of_time_; }

  // Where the samples are when they lie in files as they are, or packed as a whole; nullopt when
  // they must be read through read(). Requires dims within the largest grid. Throws
  // VolumeFileError.
  [[nodiscard]] std::optional<PlainPayload> plain_payload() const;

  // All samples into `memory`, x fastest, in the byte order of this machine. Throws
  // VolumeFileError, also when the file holds less than its header promises.
  void read(void* memory) const;

 private:
  struct Reader;
  // The time that is chosen of `times`; nullopt when there is one only.
  [[nodiscard]] std::optional<std::int64_t> chosen_time(const VolumeChoice& choice) const;

  std::filesystem::path file_;
  ImageHeader header_;
  SourceMembers members_;
  std::optional<int> component_of_time_;
  VolumeInFile volume_;
  std::unique_ptr<Reader> reader_;
};

}  // namespace multitetra
