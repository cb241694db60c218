#include "server/volume/placement.hpp"

#include <cmath>
#include <cstddef>

namespace multitetra {
namespace {

void set_spacing(ImageHeader& header, const Vec3& spacing) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3& column = header.index_to_world.columns[axis];
    const double before = std::sqrt(dot(column, column));
    if (before > 0) {
      column = scaled(column, spacing[axis] / before);
    } else {  // A header without a usable spacing.
      column = {0, 0, 0};
      column[axis] = spacing[axis];
    }
  }
  header.spacing = spacing;
}

// RAS and LPS differ in the signs of their first two axes.
void turn_to_lps(Affine& index_to_world) {
  const auto turn = [](Vec3& v) { v = {0.0 - v[0], 0.0 - v[1], v[2]}; };
  for (Vec3& column : index_to_world.columns) turn(column);
  turn(index_to_world.translation);
}

}  // namespace

void place(ImageHeader& header, const Placement& placement) {
  if (placement.spacing) set_spacing(header, *placement.spacing);
  if (placement.origin) header.index_to_world.translation = *placement.origin;
  if (placement.space) {
    const bool is_turned = *placement.space == WorldSpace::kRas;
    if (is_turned) turn_to_lps(header.index_to_world);
    header.meaning.space = is_turned ? WorldSpace::kLps : *placement.space;
  }
  if (placement.length_unit) header.meaning.length_unit = *placement.length_unit;
}

}  // namespace multitetra
