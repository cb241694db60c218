#include "server/core/spectrum/cell_layers.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

#include "server/core/framework/axes.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kTile = 64;  // Cells read at a time along x and y.

template <typename Sample>
constexpr Sample max_sample() {
  if constexpr (std::is_floating_point_v<Sample>) return std::numeric_limits<Sample>::infinity();
  return std::numeric_limits<Sample>::max();
}
template <typename Sample>
constexpr Sample min_sample() {
  if constexpr (std::is_floating_point_v<Sample>) return -std::numeric_limits<Sample>::infinity();
  return std::numeric_limits<Sample>::lowest();
}

// A rectangle of cells in one layer.
struct CellTile {
  GridPoint begin;
  GridPoint end;
};

std::vector<CellTile> tiles_of(const CellBox& cells, std::int32_t layer) {
  std::vector<CellTile> tiles;
  for (std::int32_t y = cells.begin.y; y < cells.end.y; y += kTile) {
    for (std::int32_t x = cells.begin.x; x < cells.end.x; x += kTile) {
      tiles.push_back(
          {{x, y, layer},
           {std::min(x + kTile, cells.end.x), std::min(y + kTile, cells.end.y), layer + 1}});
    }
  }
  return tiles;
}

// The samples of the closed cells of a tile.
struct CellSamples {
  GridPoint first;
  GridPoint extent;
  Samples samples;

  CellSamples(const DatasetInfo& info, const SampleBoxes& boxes, const CellTile& tile) {
    const auto samples_at = [&](GridPoint cells) {
      return by_axis([&](int axis) {
        return std::clamp(kSpectrumSpacing * cells[axis] - info.margin, 0,
                          info.dims[static_cast<std::size_t>(axis)] - 1);
      });
    };
    first = samples_at(tile.begin);
    const GridPoint last = samples_at(tile.end);
    extent = last - first + GridPoint{1, 1, 1};
    boxes.read(first, extent, samples);
  }
  [[nodiscard]] std::ptrdiff_t index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (x - first.x) +
           std::ptrdiff_t{extent.x} * ((y - first.y) + std::ptrdiff_t{extent.y} * (z - first.z));
  }
};

// The samples of a closed cell along an axis; empty if `last` < `first`.
struct SamplesAlong {
  std::int32_t first = 0;
  std::int32_t last = 0;

  SamplesAlong(const DatasetInfo& info, std::int32_t cell, std::size_t axis) {
    const std::int32_t begin = kSpectrumSpacing * cell - info.margin;
    first = std::max(0, begin);
    last = std::min(info.dims[axis] - 1, begin + kSpectrumSpacing);
  }
};

// Visits samples in the order of CellRanges, so that zeros of either sign give the same result.
template <typename Sample>
std::array<Sample, 2> range_of(const DatasetInfo& info, const CellSamples& box,
                               const std::vector<Sample>& samples, GridPoint cell) {
  Sample low = max_sample<Sample>();
  Sample high = min_sample<Sample>();
  const SamplesAlong x(info, cell.x, 0);
  const SamplesAlong y(info, cell.y, 1);
  const SamplesAlong z(info, cell.z, 2);
  for (std::int32_t k = z.first; k <= z.last; ++k) {
    for (std::int32_t j = y.first; j <= y.last; ++j) {
      const Sample* const row = samples.data() + box.index(0, j, k);
      for (std::int32_t i = x.first; i <= x.last; ++i) {  // Comparisons with NaN are false.
        low = row[i] < low ? row[i] : low;
        high = row[i] > high ? row[i] : high;
      }
    }
  }
  return {low, high};
}

// Returns a layer with `value_of(box, samples, cell)` for every cell.
template <typename Value, typename ValueOf>
std::vector<std::byte> layer_of(const DatasetInfo& info, const SampleBoxes& boxes,
                                const CellBox& cells, std::int32_t layer, const ForEach& for_each,
                                const ValueOf& value_of) {
  const GridPoint extent = cells.end - cells.begin;
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::max(0, extent.x)) *
                               static_cast<std::size_t>(std::max(0, extent.y)) * sizeof(Value));
  const std::vector<CellTile> tiles = tiles_of(cells, layer);
  for_each(tiles.size(), [&](std::size_t t) {
    const CellSamples box(info, boxes, tiles[t]);
    for (std::int32_t y = tiles[t].begin.y; y < tiles[t].end.y; ++y) {
      for (std::int32_t x = tiles[t].begin.x; x < tiles[t].end.x; ++x) {
        const Value value = value_of(box, GridPoint{x, y, layer});
        const std::ptrdiff_t at =
            (x - cells.begin.x) + std::ptrdiff_t{extent.x} * (y - cells.begin.y);
        std::memcpy(bytes.data() + at * static_cast<std::ptrdiff_t>(sizeof(Value)), &value,
                    sizeof(Value));
      }
    }
  });
  return bytes;
}

}  // namespace

std::vector<std::byte> ranges_of_layer(const DatasetInfo& info, const SampleBoxes& samples,
                                       const CellBox& cells, std::int32_t layer,
                                       const ForEach& for_each) {
  return visit_type(info.type, [&]<typename Sample>(const Sample*) {
    return layer_of<std::array<Sample, 2>>(
        info, samples, cells, layer, for_each, [&](const CellSamples& box, GridPoint cell) {
          return range_of(info, box, std::get<std::vector<Sample>>(box.samples), cell);
        });
  });
}

std::vector<std::byte> coarse_of_layer(const DatasetInfo& info, const SampleBoxes& samples,
                                       const CellBox& points, std::int32_t layer,
                                       const ForEach& for_each) {
  return visit_type(info.type, [&]<typename Sample>(const Sample*) {
    return layer_of<Sample>(
        info, samples, points, layer, for_each, [&](const CellSamples& box, GridPoint point) {
          const GridPoint at = kSpectrumSpacing * point - first_sample(info);
          return std::get<std::vector<Sample>>(
              box.samples)[static_cast<std::size_t>(box.index(at.x, at.y, at.z))];
        });
  });
}

}  // namespace multitetra
