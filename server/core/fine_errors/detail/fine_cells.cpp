#include "server/core/fine_errors/detail/fine_cells.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "server/core/framework/rounding.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kCell = kSpectrumSpacing;

// Calls `visit` for a cell and its 26 neighbours.
template <typename Visit>
void visit_neighbourhood(GridPoint cell, const Visit& visit) {
  for (std::int32_t n = 0; n < 27; ++n) {
    visit(cell + GridPoint{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1});
  }
}

}  // namespace

FineCells::FineCells(const PreparedVolume& volume, double isovalue)
    : volume_(volume),
      in_data_(cell_extent(volume.info)),
      outside_(outside_value(volume.info)),
      isovalue_below_(rounded_down(isovalue)) {}

// Calls `visit` with cells relative to first_.
template <typename Visit>
void FineCells::visit_cells(std::int32_t begin, std::int32_t end, const Visit& visit) const {
  for (std::int32_t z = begin; z < end; ++z) {
    for (std::int32_t y = begin; y < end; ++y) {
      for (std::int32_t x = begin; x < end; ++x) visit(GridPoint{x, y, z});
    }
  }
}

// Returns whether the closed cell has values on both sides of the isovalue.
bool FineCells::may_cross(GridPoint cell) const {
  if (!in_data_.contains(cell)) return false;
  return visit_type(volume_.info.type, [&]<typename Sample>(const Sample*) {
    std::array<Sample, 2> range;
    std::memcpy(range.data(), ranges_.data() + sizeof(range) * in_data_.index(cell), sizeof(range));
    if (range[0] > range[1]) return false;  // Void, or entirely beyond the data.
    auto low = static_cast<float>(range[0]);
    auto high = static_cast<float>(range[1]);
    const GridPoint first = first_sample(volume_.info);
    const GridPoint last = last_sample(volume_.info);
    for (int axis = 0; axis < 3; ++axis) {
      if (kCell * cell[axis] < first[axis] || kCell * (cell[axis] + 1) > last[axis]) {
        low = outside_ < low ? outside_ : low;  // False if void.
        high = outside_ > high ? outside_ : high;
      }
    }
    return high > isovalue_below_ && !(low > isovalue_below_);
  });
}

bool FineCells::mark_wanted(const std::function<bool(const OctreeCube&)>& is_wanted) {
  bool any = false;
  visit_cells(1, cells_ - 1, [&](GridPoint cell) {
    const GridPoint at = first_ + cell;
    if (!is_wanted({kSpectrumExponent, at.x, at.y, at.z})) return;
    any = true;
    wanted_[index(cell)] = true;
    visit_neighbourhood(cell, [&](GridPoint near) { is_support_[index(near)] = 1; });
  });
  return any;
}

// The range of a cell also applies to the cells above it, whose diamonds reach into it.
void FineCells::mark_crossed() {
  visit_cells(-1, cells_, [&](GridPoint cell) {
    if (!may_cross(first_ + cell)) return;
    for (std::int32_t n = 0; n < 8; ++n) {
      const GridPoint at = cell + GridPoint{n & 1, n >> 1 & 1, n >> 2};
      if (std::min({at.x, at.y, at.z}) >= 0 && std::max({at.x, at.y, at.z}) < cells_) {
        is_crossed_[index(at)] = 1;
      }
    }
  });
}

void FineCells::find(const OctreeCube& cube,
                     const std::function<bool(const OctreeCube&)>& is_wanted) {
  assert(cube.exponent >= kSpectrumExponent);
  const auto first = [&](std::int32_t position) { return position * cube.side() / kCell - 1; };
  first_ = {first(cube.x), first(cube.y), first(cube.z)};
  cells_ = cube.side() / kCell + 2;
  const auto size = static_cast<std::size_t>(cells_ * cells_ * cells_);
  wanted_.assign(size, false);
  is_support_.assign(size, 0);
  is_crossed_.assign(size, 0);
  support_.clear();
  if (!mark_wanted(is_wanted)) return;
  ranges_ = volume_.ranges.bytes();
  mark_crossed();
  visit_cells(0, cells_, [&](GridPoint cell) {
    if (is_support_[index(cell)] == 0) return;
    bool is_near = false;
    visit_neighbourhood(cell, [&](GridPoint near) {
      const auto inside = [&](std::int32_t v) { return std::clamp(v, 0, cells_ - 1); };
      is_near |= is_crossed_[index({inside(near.x), inside(near.y), inside(near.z)})] != 0;
    });
    support_.push_back({.low = kCell * (first_ + cell),
                        .is_crossed = is_crossed_[index(cell)] != 0,
                        .is_near = is_near});
  });
}

}  // namespace multitetra
