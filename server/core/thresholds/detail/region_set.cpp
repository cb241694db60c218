#include "server/core/thresholds/detail/region_set.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "common/base/vec3.hpp"

namespace multitetra {

RegionSet::RegionSet(std::span<const ThresholdRegion> regions, Combination combination,
                     const Affine& to_regions, double unit)
    : to_regions_(to_regions) {
  regions_.reserve(regions.size());
  for (const ThresholdRegion& region : regions) regions_.push_back(prepared(region, unit));
  if (combination == Combination::kMinimum) {
    std::stable_sort(regions_.begin(), regions_.end(),
                     [](const Region& a, const Region& b) { return a.threshold > b.threshold; });
  }
}

RegionSet::Region RegionSet::prepared(const ThresholdRegion& region, double unit) const {
  Region result{.kind = Kind::kBox,
                .threshold = std::min(region.threshold * unit, std::numeric_limits<double>::max()),
                .box = {},
                .vector = {},
                .number = 0};
  std::visit(
      [&](const auto& shape) {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, BoxShape>) {
          result.box = {shape.low, shape.high};
        } else if constexpr (std::is_same_v<Shape, BallShape>) {
          result.kind = Kind::kBall;
          result.vector = shape.center;
          result.number = shape.radius * shape.radius;
        } else {
          // normal . (A x + t) >= offset  <=>  (A^T normal) . x >= offset - normal . t
          result.kind = Kind::kHalfSpace;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            result.vector[axis] = dot(to_regions_.columns[axis], shape.normal);
          }
          result.number = shape.offset - dot(shape.normal, to_regions_.translation);
        }
      },
      region.shape);
  return result;
}

Contact RegionSet::contact(Index i, const MappedBox& places) const {
  const Region& region = regions_[i];
  switch (region.kind) {
    case Kind::kBox:
      if (!touch(region.box, places.image)) return Contact::kDisjoint;
      return contains(region.box, places.image) ? Contact::kContains : Contact::kTouches;
    case Kind::kBall:
      if (!(squared_distance(region.vector, places.image) <= region.number))
        return Contact::kDisjoint;
      return largest_squared_distance(region.vector, places.image) <= region.number
                 ? Contact::kContains
                 : Contact::kTouches;
    case Kind::kHalfSpace: {
      const Extent extent = extent_along(region.vector, places.grid);
      if (!(extent.largest >= region.number)) return Contact::kDisjoint;
      return extent.least >= region.number ? Contact::kContains : Contact::kTouches;
    }
  }
  return Contact::kDisjoint;
}

RegionSet::List RegionSet::all() const {
  List list;
  for (Index i = size(); i-- > 0;) list.regions.push_back(i);
  return list;
}

RegionSet::List RegionSet::relevant(const List& of_outer, const Box& box) const {
  const MappedBox here = mapped(box);
  List list;
  for (const Index i : of_outer.regions) {
    const Contact found = contact(i, here);
    if (found == Contact::kDisjoint) continue;
    list.regions.push_back(i);
    list.is_closed = found == Contact::kContains;
    if (list.is_closed) break;
  }
  return list;
}

}  // namespace multitetra
