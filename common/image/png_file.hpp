// Pictures as PNG: the one file that sees libpng.
#pragma once

#include <string>

#include "common/image/picture.hpp"

namespace multitetra {

enum class PngCompression {
  kSmall,  // As small as libpng makes it.
  // Several times as fast, and somewhat larger: for interactive use.
  kQuick,
};

// The whole file's bytes; the same for the same picture and effort. Throws std::runtime_error when
// libpng does not make it, as when memory runs out. Requires at least one pixel.
[[nodiscard]] std::string png_file(const Picture& picture,
                                   PngCompression effort = PngCompression::kSmall);

}  // namespace multitetra
