#include "server/core/spectrum/crossed_octants.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// A range along one axis.
struct Span {
  std::int32_t first = 0;
  std::int32_t last = 0;
};

// Returns the cells of a cube along an axis, clipped to the `count` cells of the data from `low`.
Span cells_of(std::int32_t position, std::int32_t cells, std::int32_t low, std::int32_t count) {
  return {std::max(position * cells, low), std::min((position + 1) * cells, low + count) - 1};
}

// Calls visit(cell, low, high) for the cells of the data in a cube that are not all void, with
// their least and largest sample, until it returns true.
template <typename Visit>
void visit_cells(const PreparedVolume& volume, const OctreeCube& cube, const Visit& visit) {
  const LevelExtent cells = cell_extent(volume.info);
  const std::byte* const ranges = volume.ranges.bytes().data();
  const std::int32_t side = cube.side() >> kSpectrumExponent;
  const Span x = cells_of(cube.x, side, cells.low.x, cells.extent.x);
  const Span y = cells_of(cube.y, side, cells.low.y, cells.extent.y);
  const Span z = cells_of(cube.z, side, cells.low.z, cells.extent.z);
  visit_type(volume.info.type, [&]<typename Sample>(const Sample*) {
    for (std::int32_t k = z.first; k <= z.last; ++k) {
      for (std::int32_t j = y.first; j <= y.last; ++j) {
        for (std::int32_t i = x.first; i <= x.last; ++i) {
          std::array<Sample, 2> range;
          std::memcpy(range.data(), ranges + sizeof(range) * cells.index({i, j, k}), sizeof(range));
          const auto low = static_cast<double>(range[0]);
          const auto high = static_cast<double>(range[1]);
          if (low <= high && visit(GridPoint{i, j, k}, low, high)) return;
        }
      }
    }
  });
}

// Returns whether points of a closed cube of that side lie beyond the data along an axis.
bool is_beyond(std::int32_t position, std::int32_t side, std::int32_t low, std::int32_t high) {
  return position * side < low || (position + 1) * side > high;
}

// Returns whether the closed cube contains points beyond the data.
bool reaches_outside(const DatasetInfo& info, const OctreeCube& cube) {
  const GridPoint first = first_sample(info);
  const GridPoint last = last_sample(info);
  return is_beyond(cube.x, cube.side(), first.x, last.x) ||
         is_beyond(cube.y, cube.side(), first.y, last.y) ||
         is_beyond(cube.z, cube.side(), first.z, last.z);
}

void include(GridPoint cell, std::optional<CellSpan>& box) {
  if (!box) {
    box = CellSpan{cell, cell};
    return;
  }
  box->first = {std::min(box->first.x, cell.x), std::min(box->first.y, cell.y),
                std::min(box->first.z, cell.z)};
  box->last = {std::max(box->last.x, cell.x), std::max(box->last.y, cell.y),
               std::max(box->last.z, cell.z)};
}

}  // namespace

bool is_crossed(const PreparedVolume& volume, const OctreeCube& cube, double isovalue) {
  bool above = false;
  bool not_above = false;
  if (volume.info.outside && reaches_outside(volume.info, cube)) {
    above = static_cast<double>(outside_value(volume.info)) > isovalue;
    not_above = !above;
  }
  visit_cells(volume, cube, [&](GridPoint, double low, double high) {
    above |= high > isovalue;
    not_above |= !(low > isovalue);
    return above && not_above;
  });
  return above && not_above;
}

std::optional<CellSpan> crossed_cells(const PreparedVolume& volume, const OctreeCube& cube,
                                      double isovalue) {
  const DatasetInfo& info = volume.info;
  const double outside = info.outside ? static_cast<double>(outside_value(info)) : 0;
  std::optional<CellSpan> box;
  visit_cells(volume, cube, [&](GridPoint cell, double low, double high) {
    if (info.outside && reaches_outside(info, {kSpectrumExponent, cell.x, cell.y, cell.z})) {
      low = std::min(low, outside);
      high = std::max(high, outside);
    }
    if (!(low > isovalue) && high > isovalue) include(cell, box);
    return false;
  });
  return box;
}

std::uint32_t crossed_octants(const PreparedVolume& volume, const OctreeCube& cube,
                              double isovalue) {
  if (cube.exponent <= kSpectrumExponent) return 0xFF;
  std::uint32_t crossed = 0;
  for (int i = 0; i < 8; ++i) {
    crossed |= static_cast<std::uint32_t>(is_crossed(volume, cube.child(i), isovalue)) << i;
  }
  return crossed;
}

}  // namespace multitetra
