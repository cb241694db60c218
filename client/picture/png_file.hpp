// Pictures as PNG: the one file that sees libpng.
#pragma once

#include <string>

#include "client/picture/picture.hpp"

namespace multitetra {

// The whole file's bytes; the same for the same picture. Throws std::runtime_error when libpng does
// not make it, as when memory runs out. Requires at least one pixel.
[[nodiscard]] std::string png_file(const Picture& picture);

}  // namespace multitetra
