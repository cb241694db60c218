#include "server/core/simplification/detail/allowed_distance.hpp"

namespace multitetra {

Box PieceFrame::grid_box(const Box& box, double reach) const {
  // Lattice steps; more than snapping to the lattice moves a vertex.
  constexpr double kSnapping = 2;
  const Vec3 lattice = {static_cast<double>(origin.x), static_cast<double>(origin.y),
                        static_cast<double>(origin.z)};
  Box grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double steps = reach / proportions[axis] + kSnapping;
    grid.low[axis] =
        (box.low[axis] / proportions[axis] + lattice[axis] - steps) / lattice_per_voxel;
    grid.high[axis] =
        (box.high[axis] / proportions[axis] + lattice[axis] + steps) / lattice_per_voxel;
  }
  return grid;
}

PieceLimit::PieceLimit(const AllowedDistance& limit, const PieceFrame& frame,
                       std::span<const Vec3> positions)
    : limit_(limit), frame_(frame), largest_(limit.largest() / frame.unit), is_uniform_(false) {
  // No larger distance is ever passed.
  is_uniform_ = least_near(box_of(positions), largest_, largest_) == largest_;
}

double PieceLimit::least_near(const Box& box, double reach, double distance) const {
  const double all = reach + limit_.model_per_simplification() * distance;
  return limit_.least_in(frame_.grid_box(box, all)) / frame_.unit;
}

}  // namespace multitetra
