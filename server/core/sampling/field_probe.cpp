#include "server/core/sampling/field_probe.hpp"

#include <cmath>

#include "server/core/sampling/sample_reader.hpp"

namespace multitetra {
namespace {

// Returns the slope per sample step; 0 if neither neighbour has a value.
double slope(double below, double here, double above) {
  if (!std::isnan(below) && !std::isnan(above)) return 0.5 * (above - below);
  if (!std::isnan(above)) return above - here;
  return std::isnan(below) ? 0 : here - below;
}

// Transforms a covector of sample indices to the world: by the inverse transpose of the map.
Vec3 world_gradient(const Vec3& gradient, const Affine& world_to_index) {
  return {dot(world_to_index.columns[0], gradient), dot(world_to_index.columns[1], gradient),
          dot(world_to_index.columns[2], gradient)};
}

}  // namespace

ProbedPlace probed(const PreparedVolume& volume, CoordinateSystem coordinates, const Vec3& place) {
  const DatasetInfo& info = volume.info;
  const Affine world_to_index = inverse(info.index_to_world);
  const bool is_world = coordinates == CoordinateSystem::kWorld;
  ProbedPlace found{.world = is_world ? place : info.index_to_world(place),
                    .index = is_world ? world_to_index(place) : place};
  visit_type(info.type, [&]<typename Sample>(const Sample*) {
    BrickReader<Sample> reader(volume);
    const auto value = [&](const Vec3& index) { return value_at(reader, info, index); };
    const double here = value(found.index);
    if (std::isnan(here)) return;
    Vec3 gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3 below = found.index;
      Vec3 above = found.index;
      below[axis] -= 1;
      above[axis] += 1;
      gradient[axis] = slope(value(below), here, value(above));
    }
    found.value = here;
    found.gradient = world_gradient(gradient, world_to_index);
  });
  return found;
}

}  // namespace multitetra
