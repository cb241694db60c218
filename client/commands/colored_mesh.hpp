// Surfaces that are colored by a field.
#pragma once

#include <string>

#include "client/library/assembler.hpp"
#include "common/image/color_map.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

// Gives the mesh the colors of its scalars, if it has some; the ends of the scale are those of the
// step.
void paint(PositionedMesh& mesh, const StepBegin& step, ColorScale scale);

// "Colors between vertices may be off by up to 0.12, those of vertices by 0.01."; empty without
// scalars.
[[nodiscard]] std::string accuracy_text(const CommittedStep& step);

}  // namespace multitetra
