// The container of binary glTF 2.0, and what all our files of that kind have in common.
#pragma once

#include <cstddef>
#include <string>

#include <nlohmann/json.hpp>

namespace multitetra {

// Asset and an empty scene.
[[nodiscard]] nlohmann::json empty_gltf();
// Seen from both sides, dull.
[[nodiscard]] nlohmann::json surface_material();
// The file up to the bytes of its binary chunk, which has `binary` of them, a multiple of 4, for
// the caller to append: a 12-byte header, a JSON chunk padded with spaces and, unless `binary` is
// 0, the chunk's header. Room for all is reserved. Throws std::system_error beyond glTF's 4 GiB.
[[nodiscard]] std::string glb_beginning(const nlohmann::json& json, std::size_t binary);

}  // namespace multitetra
