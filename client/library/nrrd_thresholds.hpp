// Reads thresholds from NRRD files, the only image format the client reads.
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// Reads scalars of any type in two or three dimensions, encoded as raw, gzip or ascii, after the
// header or in a file in the header's folder. Samples lie where volume readers have them
// (nrrd_placement.hpp), in the unit `length_unit` if both units are known. Images too large for a
// request are reduced by taking minima (threshold_shrinking.hpp). Where the image has no threshold
// (NaN), `elsewhere` applies.
//
// Returns kInvalidArgument, with the file's name, if the file cannot be read or is not such an
// image; kLimitExceeded above 2^29 samples. Does not check the thresholds: `validated` does.
[[nodiscard]] Result<ThresholdGrid> read_nrrd_thresholds(const std::filesystem::path& file,
                                                         double elsewhere,
                                                         const std::string& length_unit = {});

}  // namespace multitetra
