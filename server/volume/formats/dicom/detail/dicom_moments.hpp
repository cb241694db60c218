// What tells images at one position apart: their place in time, and how they were acquired.
#pragma once

#include <gdcmDataSet.h>

#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/dicom/detail/dicom_image.hpp"

namespace multitetra {

// Sets the moment of an image from its file, or from the functional groups of its frame.
void set_moment(const gdcm::DataSet& file, DicomImage& image);
void set_moment_of_frame(const gdcm::DataSet& groups, DicomImage& image);

// The images at each position, in the order of positions.
using DicomPositions = std::vector<std::vector<DicomImage>>;

// Orders the images at each position, of which there are equally many everywhere, so that those of
// one rank are of one moment wherever elements say so; otherwise by number, file and frame. Returns
// a sentence if only names of files tell some apart, else an empty one.
[[nodiscard]] std::string order_by_moment(DicomPositions& positions);

// Returns one image at each position if some element has a value that exactly one image has
// everywhere; for series in which not all positions have equally many images.
[[nodiscard]] std::optional<std::vector<DicomImage>> images_of_one_moment(
    const DicomPositions& positions);

// Returns a sentence if neighbouring slices alternate between moments, as those of two volumes with
// the same distances do; empty if they do not.
[[nodiscard]] std::string alternation_in(const std::vector<DicomImage>& stack);

}  // namespace multitetra
