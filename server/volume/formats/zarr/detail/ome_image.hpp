// The levels of an OME-Zarr image, versions 0.1 to 0.6, and the images of a group.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/volume/formats/arrays/conventions.hpp"
#include "server/volume/formats/zarr/detail/zarr_container.hpp"

namespace multitetra {

struct OmeLevel {
  std::string path;      // Of its array, relative to the image.
  ArrayMeaning meaning;  // Roles, placement and times.
  // The names of all images with these attributes, for choice.series.
  std::vector<std::string> images = {};
};

// Returns the level of choice.level of the image with these attributes, counted from the finest one
// whatever their order; nullopt if they describe no image. Transformations other than scales,
// translations and affine maps are refused, unless the user gives spacing and origin.
[[nodiscard]] std::optional<OmeLevel> ome_level(const nlohmann::json& attributes,
                                                const VolumeChoice& choice,
                                                const std::filesystem::path& place);

// Returns the paths of the images in a group without one of its own: those of bioformats2raw, or
// the fields of a plate.
[[nodiscard]] std::vector<std::string> ome_images(const ZarrContainer& container,
                                                  const std::string& group);

}  // namespace multitetra
