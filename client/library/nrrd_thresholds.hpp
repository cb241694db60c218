// Thresholds from a NRRD file: the one image format that the client reads.
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// Reads scalars of two or three dimensions and of any type, encoded as raw, gzip or ascii, behind
// the header or in a file in the header's folder. The first sample lies at the space origin; RAS
// and LAS become LPS. Larger images are shrunk by minimum until a request may contain them
// (threshold_shrinking.hpp); `elsewhere` is the threshold where the image has none (NaN).
//
// kInvalidArgument, with the file's name, when it cannot be read or is no such image,
// kLimitExceeded above 2^29 samples. Its thresholds are not checked: `validated` does.
[[nodiscard]] Result<ThresholdGrid> read_nrrd_thresholds(const std::filesystem::path& file,
                                                         double elsewhere);

}  // namespace multitetra
