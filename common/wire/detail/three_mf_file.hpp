// 3MF files, which slicers read: a zip archive with a model in XML.
#pragma once

#include <span>
#include <string>

#include "common/wire/scene_file.hpp"

namespace multitetra {

// Returns the bytes of the file: an object with a color for each part that has triangles, a model
// if it is closed, else a surface. Units that 3MF does not know are named in its description alone,
// as `title` is. Coordinates have as many digits as their place needs. Throws std::system_error.
[[nodiscard]] std::string three_mf_file(std::span<const ScenePart> parts,
                                        const PhysicalMeaning& world, const std::string& title);

}  // namespace multitetra
