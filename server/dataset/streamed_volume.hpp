// A VolumeSource over slices that lie in files: read when they are asked for, then converted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/dataset/image_file.hpp"
#include "server/dataset/plain_payload.hpp"
#include "server/dataset/sample_conversion.hpp"
#include "server/dataset/volume_source.hpp"

namespace multitetra {

// Slices of a volume in the type they have in their files.
class StoredSlices {
 public:
  virtual ~StoredSlices() = default;
  // The slices first ... first + count - 1, in the byte order of this machine. Throws
  // VolumeFileError.
  virtual void read(std::size_t first, std::size_t count, std::byte* into) = 0;
};

// The slices of a payload. Throws VolumeFileError when its files end too early.
[[nodiscard]] std::unique_ptr<StoredSlices> slices_of(PlainPayload payload,
                                                      const ImageHeader& header);

// The header of a volume from the header of an image. Requires dims within the largest grid.
[[nodiscard]] VolumeHeader volume_header(const ImageHeader& image);

// The volume that `slices` make up. `file` is its name in notices. Tells `notice` of a conversion
// at once, and of infinite samples when the last slice has been read for the first time.
[[nodiscard]] std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file,
                                                            const ImageHeader& header,
                                                            std::unique_ptr<StoredSlices> slices,
                                                            Notice notice);

}  // namespace multitetra
