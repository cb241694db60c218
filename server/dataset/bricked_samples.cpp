#include "server/dataset/bricked_samples.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kSide = BrickLayout::kSampleSide;

// Copies the part of a brick that lies in the box from `first` to `end` (exclusive).
template <typename Sample>
void copy_brick(const Sample* from, const BrickLayout& layout, const GridCounts& brick,
                GridPoint first, GridPoint end, Sample* box) {
  const GridCounts extent = layout.extent(brick);
  const GridPoint low = kSide * GridPoint{brick[0], brick[1], brick[2]};
  const std::int32_t begin_x = std::max(low.x, first.x);
  const std::int32_t end_x = std::min(low.x + extent[0], end.x);
  for (std::int32_t z = std::max(low.z, first.z); z < std::min(low.z + extent[2], end.z); ++z) {
    for (std::int32_t y = std::max(low.y, first.y); y < std::min(low.y + extent[1], end.y); ++y) {
      const Sample* const row = from + extent[0] * ((y - low.y) + extent[1] * (z - low.z));
      Sample* const into =
          box + std::ptrdiff_t{end.x - first.x} *
                    ((y - first.y) + std::ptrdiff_t{end.y - first.y} * (z - first.z));
      std::copy(row + (begin_x - low.x), row + (end_x - low.x), into + (begin_x - first.x));
    }
  }
}

}  // namespace

void BrickedSamples::read(GridPoint first, GridPoint extent, Samples& into) const {
  visit_type(type_, [&]<typename Sample>(const Sample*) {
    if (!std::holds_alternative<std::vector<Sample>>(into)) into = std::vector<Sample>();
    auto& samples = std::get<std::vector<Sample>>(into);
    samples.resize(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
                   static_cast<std::size_t>(extent.z));
    read_typed(first, first + extent, samples);
  });
}

template <typename Sample>
void BrickedSamples::read_typed(GridPoint first, GridPoint end, std::vector<Sample>& into) const {
  std::vector<Sample> row;
  const std::int32_t begin_x = first.x / kSide;
  const std::int32_t end_x = (end.x - 1) / kSide + 1;
  for (std::int32_t z = first.z / kSide; z <= (end.z - 1) / kSide; ++z) {
    for (std::int32_t y = first.y / kSide; y <= (end.y - 1) / kSide; ++y) {
      const GridCounts begin = {begin_x, y, z};
      const GridCounts last = {end_x - 1, y, z};
      const std::uint64_t offset = layout_.offset(begin);
      row.resize(layout_.offset(last) + layout_.volume(last) - offset);
      read_(layout_.index(begin), std::as_writable_bytes(std::span(row)));
      for (std::int32_t x = begin_x; x < end_x; ++x) {
        const GridCounts brick = {x, y, z};
        copy_brick(row.data() + (layout_.offset(brick) - offset), layout_, brick, first, end,
                   into.data());
      }
    }
  }
}

}  // namespace multitetra
