// Surfaces colored by a field.
#pragma once

#include <optional>

#include "common/image/color_map.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

// Colors the mesh by its scalars, if it has any, over their range.
void paint(PositionedMesh& mesh, const std::optional<ScalarRange>& range, ColorScale scale);

}  // namespace multitetra
