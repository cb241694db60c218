// Samples written as numbers in text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The location of the numbers in a file, and how many of them precede the first sample.
struct NumbersInText {
  std::filesystem::path file;
  std::uint64_t begin = 0;
  // 0 means the end of the file.
  std::uint64_t end = 0;
  std::uint64_t skipped = 0;
  bool are_all = false;  // Nothing should follow the last number of the header.
  // kGzip or kBzip2 if the whole file is compressed; offsets then count unpacked bytes.
  Packing packing = Packing::kNone;
};

// Returns the slices of `header` from numbers between white space or commas. They are read forward;
// going back starts over. Reading throws VolumeFileError if the text ends or a number does not fit
// the header's type. Floats too small for their type become 0, too large ones infinite. Findings
// tell whether something follows the numbers if they are all.
[[nodiscard]] std::unique_ptr<StoredSlices> text_slices(NumbersInText numbers,
                                                        const ImageHeader& header);

}  // namespace multitetra
