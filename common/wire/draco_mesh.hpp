// Meshes of other programs' Draco files. Our own tiles are decoded with more care: see tile.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

struct DracoMesh {
  std::vector<Vec3> positions;
  std::vector<TriangleIndices> triangles;
};

// `position_id` names the attribute as glTF does; none: the file's only positions. kDamagedData
// when it is no triangle mesh that Draco decodes. Draco allocates the memory that the bytes claim:
// run this where memory is bounded (child_process.hpp).
[[nodiscard]] Result<DracoMesh> decode_draco_mesh(std::string_view bytes,
                                                  std::optional<std::uint32_t> position_id);

}  // namespace multitetra
