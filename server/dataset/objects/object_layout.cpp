#include "server/dataset/objects/object_layout.hpp"

#include <algorithm>
#include <utility>

#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// Every third bit.
std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

// The places of `layout` in Morton order.
std::vector<std::size_t> in_morton_order(const BrickLayout& layout) {
  std::vector<std::pair<std::uint64_t, std::size_t>> numbered(layout.size());
  for (std::size_t i = 0; i < numbered.size(); ++i) {
    numbered[i] = {morton_number(layout.at(i)), i};
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::size_t> order;
  order.reserve(numbered.size());
  for (const auto& [number, index] : numbered) order.push_back(index);
  return order;
}

// A level's bricks that are not empty, in Morton order, and where each begins among their bytes.
struct LevelBricks {
  std::vector<std::uint64_t> morton;
  std::vector<std::size_t> bricks;
  std::vector<std::uint64_t> begins;  // One more than bricks: the last is the sum.

  LevelBricks(const SpectrumLayout::Level& level, std::span<const BrickPlace> index) {
    begins.push_back(0);
    for (const std::size_t i : in_morton_order(level.bricks)) {
      const std::size_t brick = level.first_brick + i;
      if (index[brick].size == 0) continue;
      morton.push_back(morton_number(level.bricks.at(i)));
      bricks.push_back(brick);
      begins.push_back(begins.back() + index[brick].size);
    }
  }

  // Calls `visit(begin, end)` for the parts that are objects, in order.
  template <typename Visit>
  void cut(std::size_t begin, std::size_t end, int exponent, const Visit& visit) const {
    if (begin == end) return;
    if (exponent == 0 || begins[end] - begins[begin] <= SpectrumObjects::kSpectrumObjectBytes) {
      visit(begin, end);
      return;
    }
    const int child_bits = 3 * (exponent - 1);
    while (begin != end) {
      const std::uint64_t next = ((morton[begin] >> child_bits) + 1) << child_bits;
      const auto stop = std::lower_bound(morton.begin() + static_cast<std::ptrdiff_t>(begin),
                                         morton.begin() + static_cast<std::ptrdiff_t>(end), next);
      const auto child_end = static_cast<std::size_t>(stop - morton.begin());
      cut(begin, child_end, exponent - 1, visit);
      begin = child_end;
    }
  }
};

}  // namespace

std::uint64_t morton_number(const GridCounts& at) {
  const auto bits = [&](std::size_t axis) {
    return spread_bits(static_cast<std::uint64_t>(at[axis]));
  };
  return bits(0) | bits(1) << 1 | bits(2) << 2;
}

// ---- samples

SampleObjects::SampleObjects(const GridCounts& dims, SampleType type)
    : bricks_(dims),
      boxes_(bricks_.counts(), kBricks),
      width_(static_cast<std::uint32_t>(bytes_per_sample(type))),
      order_(in_morton_order(boxes_)),
      rank_(order_.size()) {
  for (std::size_t object = 0; object < order_.size(); ++object) rank_[order_[object]] = object;
  std::array<bool, 8> is_filled{};
  for (std::size_t object = 0; object < order_.size(); ++object) {
    const std::size_t shape = shape_of(box_of(object));
    if (std::exchange(is_filled[shape], true)) continue;
    std::uint32_t offset = 0;
    for (const std::size_t brick : bricks_of(object)) {
      const GridCounts at = bricks_.at(brick);
      offsets_[shape][morton_number({at[0] % kBricks, at[1] % kBricks, at[2] % kBricks})] = offset;
      offset += static_cast<std::uint32_t>(bricks_.volume(at)) * width_;
    }
  }
}

std::size_t SampleObjects::shape_of(const GridCounts& box) const {
  std::size_t shape = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box[axis] + 1 == boxes_.counts()[axis]) shape |= std::size_t{1} << axis;
  }
  return shape;
}

BrickInObject SampleObjects::place(std::size_t brick) const {
  const GridCounts at = bricks_.at(brick);
  const GridCounts box = {at[0] / kBricks, at[1] / kBricks, at[2] / kBricks};
  return {.object = object_at(box),
          .offset = offsets_[shape_of(box)]
                            [morton_number({at[0] % kBricks, at[1] % kBricks, at[2] % kBricks})],
          .size = static_cast<std::uint32_t>(bricks_.volume(at)) * width_};
}

std::vector<std::size_t> SampleObjects::bricks_of(std::size_t object) const {
  const GridCounts box = box_of(object);
  const GridCounts extent = boxes_.extent(box);
  const BrickLayout inside(extent, 1);
  std::vector<std::size_t> bricks;
  for (const std::size_t i : in_morton_order(inside)) {
    const GridCounts at = inside.at(i);
    bricks.push_back(bricks_.index(
        {kBricks * box[0] + at[0], kBricks * box[1] + at[1], kBricks * box[2] + at[2]}));
  }
  return bricks;
}

std::uint32_t SampleObjects::bytes_of(std::size_t object) const {
  const GridCounts box = box_of(object);
  std::uint32_t bytes = width_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bytes *=
        static_cast<std::uint32_t>(std::min(kSamples, bricks_.dims()[axis] - kSamples * box[axis]));
  }
  return bytes;
}

// ---- spectrum

SpectrumObjects::SpectrumObjects(const DatasetInfo& info, std::span<const BrickPlace> index)
    : places_(index.size()) {
  const SpectrumLayout layout(info);
  std::uint64_t together = 0;
  bool is_alone = false;  // From the first level that does not fit with the coarser ones.
  for (auto level = layout.levels().rbegin(); level != layout.levels().rend(); ++level) {
    const LevelBricks bricks(*level, index);
    is_alone = is_alone || together + bricks.begins.back() > kSpectrumObjectBytes;
    const std::size_t first = order_.size();
    if (is_alone && together > 0) add_object(0, first, index);
    order_.insert(order_.end(), bricks.bricks.begin(), bricks.bricks.end());
    if (!is_alone) {
      together += bricks.begins.back();
      continue;
    }
    together = 0;
    int exponent = 0;
    for (const std::int32_t count : level->bricks.counts()) {
      while ((1 << exponent) < count) ++exponent;
    }
    bricks.cut(0, bricks.bricks.size(), exponent, [&](std::size_t begin, std::size_t end) {
      add_object(first + begin, first + end, index);
    });
  }
  if (together > 0) add_object(0, order_.size(), index);
}

void SpectrumObjects::add_object(std::size_t begin, std::size_t end,
                                 std::span<const BrickPlace> index) {
  std::uint32_t offset = 0;
  for (std::size_t i = begin; i < end; ++i) {
    places_[order_[i]] = {
        .object = begins_.size(), .offset = offset, .size = index[order_[i]].size};
    offset += index[order_[i]].size;
  }
  begins_.push_back(begin);
}

std::span<const std::size_t> SpectrumObjects::bricks_of(std::size_t object) const {
  const std::size_t end = object + 1 < begins_.size() ? begins_[object + 1] : order_.size();
  return std::span(order_).subspan(begins_[object], end - begins_[object]);
}

}  // namespace multitetra
