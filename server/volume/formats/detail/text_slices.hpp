// Samples written as numbers in text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The position of the numbers in a file, and how many of them come before the first sample.
struct NumbersInText {
  std::filesystem::path file;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;  // 0: the end of the file.
  std::uint64_t skipped = 0;
  // kGzip or kBzip2: of the whole file, and places are those in what it holds.
  Packing packing = Packing::kNone;
};

// The slices of `header`, of numbers between white space or commas. They are read forwards; going
// back starts over. Reading throws VolumeFileError where the text ends or has no number of the
// header's type. Floating-point numbers too small for their type are 0, too large ones infinite.
[[nodiscard]] std::unique_ptr<StoredSlices> text_slices(NumbersInText numbers,
                                                        const ImageHeader& header);

}  // namespace multitetra
