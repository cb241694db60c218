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

#include "common/base/affine.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

// The types that samples have in files. The first five are those of SampleType, in its order.
enum class StoredType { kU8, kI8, kU16, kI16, kF32, kU32, kI32, kU64, kI64, kF64 };

[[nodiscard]] std::size_t bytes_of(StoredType type);

struct ImageHeader {
  std::array<std::int64_t, 3> dims = {1, 1, 1};  // As the file says: not checked against anything.
  StoredType type = StoredType::kU8;
  Vec3 spacing = {1, 1, 1};
  Affine index_to_world;
};

inline constexpr std::string_view kKnownVolumeFiles =
    ".nrrd, .nhdr (NRRD), .mha, .mhd (MetaImage), .nii, .nii.gz (NIfTI), .vtk (legacy VTK), .tif, "
    ".tiff (TIFF), a directory or pattern of TIFF images, or raw bytes with a given layout";

// Throws VolumeFileError: "Cannot read '<file>': <problem>. <remedy>."
[[noreturn]] void fail_reading(const std::filesystem::path& file, const std::string& problem,
                               const std::string& remedy);

struct PlainPayload;

class ImageFile {
 public:
  // Reads the header. Throws VolumeFileError when the suffix names no known format, the header is
  // damaged, or it is no scalar image of two or three dimensions (more may follow with one entry).
  explicit ImageFile(const std::filesystem::path& file);
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

// Writes a NRRD under exactly this name. Throws VolumeFileError.
void write_nrrd_image(const std::filesystem::path& file, const Volume& volume);

}  // namespace multitetra
