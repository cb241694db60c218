// The samples as an image in neuroglancer's precomputed format, in their place in the world.
//
// The format's voxels lie along the axes and begin at whole voxels. Samples that are stored along
// other axes or backwards are reordered, so a voxel is a sample; a rotated or sheared volume is
// resampled onto the axes (the nearest sample). Image and surfaces are shifted together, by at most
// half a voxel along each axis, since a sample is in the middle of its voxel.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/affine.hpp"
#include "common/dataset/dataset_info.hpp"

namespace multitetra {

[[nodiscard]] std::string image_info_json(const DatasetInfo& info);

// A chunk of the image: "0-64_64-128_0-16" at scale "4_4_4", which has every fourth voxel.
struct ImageChunk {
  std::array<std::int32_t, 3> size{};  // In voxels of the scale.
  Affine to_index;                     // From voxels, counted from the chunk's first, to samples.
};
// Returns none for chunks that image_info_json() does not offer.
[[nodiscard]] std::optional<ImageChunk> image_chunk_from(const DatasetInfo& info,
                                                         std::string_view scale,
                                                         std::string_view chunk);

// Maps coordinates of manifests, along the grid's axes, to those of the image; both in nanometres.
[[nodiscard]] Affine manifest_to_image(const DatasetInfo& info);

}  // namespace multitetra
