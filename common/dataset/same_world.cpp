#include "common/dataset/same_world.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "common/base/number_at_resolution.hpp"

namespace multitetra {
namespace {

struct WorldBox {
  Vec3 low;
  Vec3 high;
};

WorldBox box_of(const DatasetInfo& info) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  WorldBox box{.low = {kFar, kFar, kFar}, .high = {-kFar, -kFar, -kFar}};
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      index[axis] = (corner >> axis & 1) != 0 ? info.dims[axis] - 1 : 0;
    }
    const Vec3 place = info.index_to_world(index);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], place[axis]);
      box.high[axis] = std::max(box.high[axis], place[axis]);
    }
  }
  return box;
}

std::string extent_text(const WorldBox& box, std::size_t axis) {
  const double resolution = 1e-4 * (box.high[axis] - box.low[axis]);
  return number_at(box.low[axis], resolution) + " to " + number_at(box.high[axis], resolution);
}

}  // namespace

std::string world_mismatch(const DatasetInfo& surface, const DatasetInfo& values) {
  const std::string both = "\"" + values.name + "\" and \"" + surface.name + "\"";
  const PhysicalMeaning& a = values.meaning;
  const PhysicalMeaning& b = surface.meaning;
  if (a.space != b.space && a.space != WorldSpace::kUnnamed && b.space != WorldSpace::kUnnamed) {
    return both + " have different world axes: " + std::string(name(a.space)) + " and " +
           std::string(name(b.space)) + ".";
  }
  if (a.length_unit != b.length_unit && !a.length_unit.empty() && !b.length_unit.empty()) {
    return both + " have different units of length: " + a.length_unit + " and " + b.length_unit +
           ".";
  }
  const WorldBox first = box_of(values);
  const WorldBox second = box_of(surface);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (first.low[axis] <= second.high[axis] && second.low[axis] <= first.high[axis]) continue;
    return both + " are at different positions: along " + "xyz"[axis] + " from " +
           extent_text(first, axis) + " and from " + extent_text(second, axis) + ".";
  }
  return {};
}

}  // namespace multitetra
