#include "common/request/painted_mesh.hpp"

namespace multitetra {

void paint(PositionedMesh& mesh, const std::optional<ScalarRange>& range, ColorScale scale) {
  if (!range || mesh.scalars.empty()) return;
  scale.low = range->low;
  scale.high = range->high;
  mesh.colors = colors_of(mesh.scalars, scale);
}

}  // namespace multitetra
