// A coarse grid of thresholds from an image file. The one file of common that sees ITK.
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// Reads a scalar image of two or three dimensions: NRRD, MetaImage, NIfTI, legacy VTK, TIFF, GIPL,
// MRC, BioRad, Stimulate, PNG, BMP or JPEG, told by its content. Larger ones are
// shrunk by minimum until a request may carry them (threshold_shrinking.hpp); `elsewhere` is the
// threshold where the image says nothing.
//
// kInvalidArgument, with the file's name, when it cannot be read or is no such image,
// kLimitExceeded above 2^29 samples. Its thresholds are not checked: `validated` does.
[[nodiscard]] Result<ThresholdGrid> read_threshold_grid(const std::filesystem::path& file,
                                                        double elsewhere);

}  // namespace multitetra
