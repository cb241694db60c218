// What lies behind an image header that ITK has read: whether the file is whole, and where its
// samples are.
//
// ITK takes some damaged files for whole: MetaImage and legacy VTK files that end too early
// are filled up with zeros. Here every file is checked to hold what its header promises.
#pragma once

#include <itkImageIOBase.h>

#include <filesystem>
#include <optional>

#include "server/dataset/image_file.hpp"
#include "server/dataset/plain_payload.hpp"

namespace multitetra {

// Throws VolumeFileError unless the header of a MetaImage, whose name this is, is one that ITK can
// be trusted with, and its data file lies in its folder (or `follow`).
void check_meta_image_header(const std::filesystem::path& file, bool follow);

// Throws VolumeFileError unless the file holds what the header that `io` has read promises.
void check_payload(const std::filesystem::path& file, itk::ImageIOBase& io);

// Where the samples of a volume lie when they can be read without ITK: NRRD that is raw or packed,
// MetaImage that is binary, legacy VTK that is; nullopt otherwise. Requires dims within the
// largest grid. Throws VolumeFileError for what check_payload refuses, except a file that ends too
// early.
[[nodiscard]] std::optional<PlainPayload> plain_payload(const std::filesystem::path& file,
                                                        const ImageHeader& header,
                                                        const VolumeInFile& volume,
                                                        itk::ImageIOBase& io);

}  // namespace multitetra
