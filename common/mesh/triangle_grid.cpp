#include "common/mesh/triangle_grid.hpp"

#include <algorithm>
#include <bit>

namespace multitetra {

TriangleBox box_of(const LatticeTriangle& t) {
  return {{std::min({t[0].x, t[1].x, t[2].x}), std::min({t[0].y, t[1].y, t[2].y}),
           std::min({t[0].z, t[1].z, t[2].z})},
          {std::max({t[0].x, t[1].x, t[2].x}), std::max({t[0].y, t[1].y, t[2].y}),
           std::max({t[0].z, t[1].z, t[2].z})}};
}

TriangleBox box_around(const TriangleBox& a, const TriangleBox& b) {
  return {
      {std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
      {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

TriangleGrid::TriangleGrid(std::size_t count, int finest)
    : finest_(finest),
      hash_shift_(64 - std::countr_zero(std::bit_ceil(count + 16))),
      first_(std::bit_ceil(count + 16), kNone),
      filed_(count) {}

TriangleGrid::Cell TriangleGrid::cell_of(const TriangleBox& box) const {
  const std::int32_t side = std::max(
      {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z, std::int32_t{1}});
  const auto bits = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(side - 1)));
  const int level = (std::max(bits, finest_) - finest_ + 1) / 2;
  const int shift = finest_ + 2 * level;
  return {box.low.x >> shift, box.low.y >> shift, box.low.z >> shift, level};
}

void TriangleGrid::insert(std::uint32_t triangle, const TriangleBox& box) {
  Filed& filed = filed_[triangle];
  filed.box = box;
  filed.cell = cell_of(box);
  std::uint32_t& first = first_[slot(filed.cell)];
  filed.previous = kNone;
  filed.next = first;
  if (first != kNone) filed_[first].previous = triangle;
  first = triangle;
  ++at_level_[static_cast<std::size_t>(filed.cell.level)];
}

void TriangleGrid::remove(std::uint32_t triangle) {
  const Filed& filed = filed_[triangle];
  if (filed.next != kNone) filed_[filed.next].previous = filed.previous;
  (filed.previous == kNone ? first_[slot(filed.cell)] : filed_[filed.previous].next) = filed.next;
  --at_level_[static_cast<std::size_t>(filed.cell.level)];
}

}  // namespace multitetra
