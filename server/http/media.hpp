// Media types: of files by name, and the mesh format that a client accepts. Pure.
#pragma once

#include <optional>
#include <string_view>

#include "common/wire/mesh_files.hpp"

namespace multitetra {

// Returns the type by suffix, such as "text/html; charset=utf-8"; else "application/octet-stream".
[[nodiscard]] std::string_view media_type_of_file(std::string_view name);

// Returns the format that an Accept field (RFC 9110) prefers; among equal ones the first of glb,
// ply, stl, obj, drc, vtp, 3mf. Returns glb for an empty field, nullopt if none is accepted.
[[nodiscard]] std::optional<MeshFormat> accepted_format(std::string_view accept);

}  // namespace multitetra
