// In which order a file has the bytes of a number.
#pragma once

namespace multitetra {

enum class Endian { kLittle, kBig };

}  // namespace multitetra
