// Media types: of files by their names, and which mesh format a client accepts. Pure.
#pragma once

#include <optional>
#include <string_view>

#include "common/wire/mesh_files.hpp"

namespace multitetra {

// "text/html; charset=utf-8" and so on, by the name's suffix; "application/octet-stream" otherwise.
[[nodiscard]] std::string_view media_type_of_file(std::string_view name);

// The format that an Accept field (RFC 9110) likes best, of equally good ones the first of glb,
// ply, stl, obj, drc, vtp; glb for an empty field; nullopt if none is accepted.
[[nodiscard]] std::optional<MeshFormat> accepted_format(std::string_view accept);

}  // namespace multitetra
