// The container format of binary glTF 2.0, and the contents all our GLB files share.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "common/base/json.hpp"
#include "common/dataset/surface_name.hpp"

namespace multitetra {

// Returns the asset information and an empty scene.
[[nodiscard]] nlohmann::json empty_gltf();
// Returns the color of a surface in linear light: its own, or the part_color() of its number.
[[nodiscard]] std::array<double, 3> color_of(const SurfaceName& name, std::size_t number);
// Returns a double-sided, matte material.
[[nodiscard]] nlohmann::json surface_material(const std::array<double, 3>& color);
// Gives a node its name, and its extras the number of its label ("label"), as far as there are any.
void name_node(nlohmann::json& node, const SurfaceName& name);
// Returns the file up to its binary chunk, whose `binary` bytes (a multiple of 4) the caller
// appends: a 12-byte header, a JSON chunk padded with spaces and, unless `binary` is 0, the header
// of the binary chunk. Reserves space for it. Throws std::system_error beyond glTF's 4 GiB.
[[nodiscard]] std::string glb_beginning(const nlohmann::json& json, std::size_t binary);

}  // namespace multitetra
