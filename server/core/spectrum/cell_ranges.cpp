#include "server/core/spectrum/cell_ranges.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kLayers = 4;  // The number of layers that 16 slices can touch.

template <typename Sample>
constexpr Sample highest() {
  if constexpr (std::is_floating_point_v<Sample>) return std::numeric_limits<Sample>::infinity();
  return std::numeric_limits<Sample>::max();
}
template <typename Sample>
constexpr Sample lowest() {
  if constexpr (std::is_floating_point_v<Sample>) return -std::numeric_limits<Sample>::infinity();
  return std::numeric_limits<Sample>::lowest();
}

// Returns the first and the last cell that contain grid coordinate v in their closed extent.
std::pair<std::int32_t, std::int32_t> cells_at(std::int32_t v) {
  const std::int32_t cell = v / kSpectrumSpacing;
  return {std::max(0, v % kSpectrumSpacing == 0 ? cell - 1 : cell), cell};
}

// Lowers `low` and raises `high` to the values of a row. Comparisons with NaN are false. Blocks of
// a constant size are vectorized.
template <typename Sample>
void fold_row(const Sample* __restrict row, Sample* __restrict low, Sample* __restrict high,
              std::size_t size) {
  constexpr std::size_t kBlock = 32;
  const auto fold = [&](std::size_t x) {
    low[x] = row[x] < low[x] ? row[x] : low[x];
    high[x] = row[x] > high[x] ? row[x] : high[x];
  };
  std::size_t x = 0;
  for (; x + kBlock <= size; x += kBlock) {
    for (std::size_t i = 0; i < kBlock; ++i) fold(x + i);
  }
  for (; x < size; ++x) fold(x);
}

// Merges the ranges of single samples along x into those of a row of cells. Both begin with the
// data.
template <typename Sample>
void include_row(const std::vector<Sample>& lows, const std::vector<Sample>& highs,
                 const DatasetInfo& info, const LevelExtent& cells, Sample* ranges) {
  for (std::int32_t i = 0; i < cells.extent.x; ++i) {
    const std::int32_t begin = kSpectrumSpacing * (cells.low.x + i) - info.margin;
    const auto first = static_cast<std::size_t>(std::max(0, begin));
    const auto last =
        static_cast<std::size_t>(std::min(info.dims[0] - 1, begin + kSpectrumSpacing));
    Sample low = ranges[2 * i];
    Sample high = ranges[2 * i + 1];
    for (std::size_t x = first; x <= last; ++x) {
      low = std::min(low, lows[x]);
      high = std::max(high, highs[x]);
    }
    ranges[2 * i] = low;
    ranges[2 * i + 1] = high;
  }
}

}  // namespace

CellRanges::CellRanges(const DatasetInfo& info, Scratch& scratch) : info_(info), scratch_(scratch) {
  visit_type(info.type, [&]<typename Sample>(const Sample*) { ranges_ = std::vector<Sample>(); });
  spill(0);
}

// Moves the first layers in memory to the scratch and starts as many new ones.
void CellRanges::spill(std::int32_t layers) {
  const LevelExtent cells = cell_extent(info_);
  const auto layer =
      2 * static_cast<std::size_t>(cells.extent.x) * static_cast<std::size_t>(cells.extent.y);
  const std::size_t size = static_cast<std::size_t>(layers) * layer;
  first_layer_ += layers;
  std::visit(
      [&](auto& ranges) {
        using Sample = typename std::decay_t<decltype(ranges)>::value_type;
        if (layers > 0) {
          (void)scratch_.put(std::as_bytes(std::span(ranges).first(size)));
          ranges.erase(ranges.begin(), ranges.begin() + static_cast<std::ptrdiff_t>(size));
        }
        for (std::size_t i = ranges.size(); i < kLayers * layer; i += 2) {
          ranges.insert(ranges.end(), {highest<Sample>(), lowest<Sample>()});
        }
      },
      ranges_);
}

void CellRanges::add(const Samples& slab, std::int32_t slices, const ForEach& for_each) {
  const LevelExtent all_cells = cell_extent(info_);
  LevelExtent cells = all_cells;  // The cells in memory.
  cells.low.z += first_layer_;
  const std::int32_t first_z = next_slice_;
  next_slice_ += slices;
  std::visit(
      [&](auto& ranges) {
        using Sample = typename std::decay_t<decltype(ranges)>::value_type;
        const auto& samples = std::get<std::decay_t<decltype(ranges)>>(slab);
        // Each row of cells along x is written by one body only.
        for_each(static_cast<std::size_t>(cells.extent.y), [&](std::size_t j) {
          const std::int32_t cell_y = cells.low.y + static_cast<std::int32_t>(j);
          const std::int32_t begin = kSpectrumSpacing * cell_y - info_.margin;
          const std::int32_t last_y = std::min(info_.dims[1] - 1, begin + kSpectrumSpacing);
          const std::int32_t end_z = cells_at(info_.margin + first_z + slices - 1).second;
          for (std::int32_t cell_z = cells.low.z; cell_z <= end_z; ++cell_z) {
            const std::int32_t begin_z = kSpectrumSpacing * cell_z - info_.margin - first_z;
            const std::int32_t last_slice = std::min(slices - 1, begin_z + kSpectrumSpacing);
            std::vector<Sample> low(static_cast<std::size_t>(info_.dims[0]), highest<Sample>());
            std::vector<Sample> high(low.size(), lowest<Sample>());
            for (std::int32_t slice = std::max(0, begin_z); slice <= last_slice; ++slice) {
              for (std::int32_t y = std::max(0, begin); y <= last_y; ++y) {
                fold_row(samples.data() + std::ptrdiff_t{info_.dims[0]} *
                                              (y + std::ptrdiff_t{info_.dims[1]} * slice),
                         low.data(), high.data(), low.size());
              }
            }
            include_row(low, high, info_, cells,
                        ranges.data() + 2 * cells.index({cells.low.x, cell_y, cell_z}));
          }
        });
      },
      ranges_);
  const bool is_last = next_slice_ == info_.dims[2];
  const std::int32_t next_layer =
      is_last ? all_cells.low.z + all_cells.extent.z : cells_at(info_.margin + next_slice_).first;
  spill(next_layer - cells.low.z);
}

std::uint64_t CellRanges::bytes() const {
  return 2 * static_cast<std::uint64_t>(bytes_per_sample(info_.type)) * cell_extent(info_).size();
}

}  // namespace multitetra
