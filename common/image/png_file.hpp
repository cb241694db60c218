// Writes PNG images; the only user of libpng.
#pragma once

#include <string>

#include "common/image/picture.hpp"

namespace multitetra {

enum class PngCompression {
  kSmall,  // libpng's default compression.
  // Several times as fast, and somewhat larger: for interactive use.
  kQuick,
};

// Returns the bytes of the file; deterministic. Throws std::runtime_error if libpng fails, for
// example when memory runs out. Requires at least one pixel.
[[nodiscard]] std::string png_file(const Picture& picture,
                                   PngCompression effort = PngCompression::kSmall);

}  // namespace multitetra
