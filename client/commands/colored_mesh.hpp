// Surfaces colored by a field.
#pragma once

#include <string>

#include "client/library/assembler.hpp"
#include "common/image/color_map.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

// Colors the mesh by its scalars, if it has any, over the step's color range.
void paint(PositionedMesh& mesh, const StepBegin& step, ColorScale scale);

// Returns "Colors between vertices may be off by up to 0.12, those of vertices by 0.01."; empty
// without scalars.
[[nodiscard]] std::string accuracy_text(const CommittedStep& step);

}  // namespace multitetra
