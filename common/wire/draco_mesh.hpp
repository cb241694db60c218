// Decodes other programs' Draco files. For our own tiles see tile.hpp, which checks more.
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

// `position_id` identifies the attribute as in glTF; absent: the file's only positions. Fails with
// kDamagedData unless Draco decodes the bytes to a triangle mesh. Draco allocates as much memory as
// the bytes claim: call this only with bounded memory (common/sandbox).
[[nodiscard]] Result<DracoMesh> decode_draco_mesh(std::string_view bytes,
                                                  std::optional<std::uint32_t> position_id);

}  // namespace multitetra
