#include "common/image/png_file.hpp"

#include <png.h>

#include <cassert>
#include <stdexcept>

namespace multitetra {

std::string png_file(const Picture& picture, PngCompression effort) {
  assert(picture.width > 0 && picture.height > 0);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGBA;
  if (effort == PngCompression::kQuick) image.flags = PNG_IMAGE_FLAG_FAST;
  const auto failed = [&image] {
    return std::runtime_error(std::string("libpng cannot write the picture: ") + image.message);
  };
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, /*convert_to_8_bit=*/0,
                                picture.pixels.data(), /*row_stride=*/0,
                                /*colormap=*/nullptr) == 0) {
    throw failed();
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace multitetra
