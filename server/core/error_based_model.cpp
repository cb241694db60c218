#include "server/core/error_based_model.hpp"

namespace multitetra {

Box region(const DividingPoint& point) {
  // Half-widths per axis: cube 3s; face 3s in its plane and 2s along its normal; edge 2s.
  const GridPoint p = point.at();
  const std::int32_t s = point.spacing();
  Box box{};
  for (int axis = 0; axis < 3; ++axis) {
    const bool in_face_plane = point.kind() == PointKind::kFace && (p[axis] & s) != 0;
    const bool wide = point.kind() == PointKind::kCube || in_face_plane;
    const std::int32_t half_width = (wide ? 3 : 2) * s;
    box.low[static_cast<std::size_t>(axis)] = p[axis] - half_width;
    box.high[static_cast<std::size_t>(axis)] = p[axis] + half_width;
  }
  return box;
}

}  // namespace multitetra
