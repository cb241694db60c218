#include "server/core/spectrum/spectrum_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "server/core/spectrum/detail/coarse_level.hpp"
#include "server/core/spectrum/detail/curve_tiles.hpp"
#include "server/core/spectrum/detail/spectrum_column.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kCell = kSpectrumSpacing;
constexpr std::int32_t kSlices = BrickLayout::kSampleSide;  // Slices read at a time.

// Column sizes in cells, those with the least seam first.
constexpr std::array<GridPoint, 9> kColumns = {{{32, 32, 64},
                                                {32, 16, 64},
                                                {16, 16, 64},
                                                {16, 16, 32},
                                                {16, 16, 16},
                                                {16, 8, 16},
                                                {8, 8, 16},
                                                {4, 4, 16},
                                                {4, 4, 8}}};

constexpr std::int32_t parts(std::int32_t count, std::int32_t size) {
  return (count + size - 1) / size;
}

// Returns the size of nearly equal parts: as many as parts of `size`, none larger.
constexpr std::int32_t evenly_divided(std::int32_t count, std::int32_t size) {
  const std::int32_t number = parts(count, size);
  return parts(count, number);
}

bool is_exact_in_float(const DatasetInfo& info) {
  const double outside = info.outside.value_or(0);
  return info.type != SampleType::kF32 && outside == std::floor(outside) &&
         std::abs(outside) <= 65536;
}

// A box of cells for the coarser levels.
struct Cells {
  GridPoint begin;
  GridPoint end;
  [[nodiscard]] GridPoint extent() const { return end - begin; }
};

template <typename Real>
class FineLevels {
 public:
  FineLevels(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work,
             const CellBox& cells)
      : info_(info),
        grid_(grid_of(info)),
        bins_(bins),
        work_(work),
        cells_{cells.begin, cells.end},
        data_end_(spectrum_cells(info).end),
        size_(column_size()),
        columns_({parts(cells_.extent().x, size_.x), parts(cells_.extent().y, size_.y),
                  parts(cells_.extent().z, size_.z)},
                 1),
        curves_(cells_.begin, cells_.end, {size_.x, size_.y, 1}, work.scratch) {}

  void make() {
    const std::size_t bytes = SpectrumColumn<Real>::max_bytes(size_.x, size_.y, bins_.count());
    const std::size_t fit = std::max<std::size_t>(1, work_.column_bytes / bytes);
    const std::size_t at_once = fit < work_.threads ? fit : columns_.size();
    for (std::size_t first = 0; first < columns_.size(); first += at_once) {
      work_.for_each(std::min(at_once, columns_.size() - first),
                     [&](std::size_t i) { make_column(columns_.at(first + i)); });
    }
  }
  [[nodiscard]] const CurveTiles& curves() const { return curves_; }
  [[nodiscard]] GridPoint tile() const { return {size_.x, size_.y, 1}; }

 private:
  // Returns the largest columns that keep all threads busy within the memory limit.
  [[nodiscard]] GridPoint column_size() const {
    const GridPoint cells = cells_.extent();
    const std::size_t wanted = work_.threads == 1 ? 1 : 2 * work_.threads;
    for (const GridPoint& size : kColumns) {
      const auto columns = static_cast<std::size_t>(parts(cells.x, size.x)) *
                           static_cast<std::size_t>(parts(cells.y, size.y)) *
                           static_cast<std::size_t>(parts(cells.z, size.z));
      const std::size_t bytes =
          SpectrumColumn<Real>::max_bytes(size.x, size.y, bins_.count()) * work_.threads;
      if (columns >= wanted && bytes <= work_.column_bytes) {
        return {evenly_divided(cells.x, size.x), evenly_divided(cells.y, size.y),
                evenly_divided(cells.z, size.z)};
      }
    }
    return kColumns.back();
  }

  void make_column(const GridCounts& at) {
    const GridPoint begin =
        cells_.begin + GridPoint{at[0] * size_.x, at[1] * size_.y, at[2] * size_.z};
    const GridPoint end = {std::min(begin.x + size_.x, cells_.end.x),
                           std::min(begin.y + size_.y, cells_.end.y),
                           std::min(begin.z + size_.z, cells_.end.z)};
    SpectrumColumn<Real> column(grid_, info_.spacing, bins_, begin, end);
    BoxPlanes values(info_);
    std::int32_t next_box = std::max(0, kCell * begin.z - column.kReach);
    for (std::int32_t z = next_box; !column.is_done(); ++z) {
      if (z == next_box) next_box = read_slices(z, begin, end, values);
      column.add(z, values, [&](std::int32_t k, const CurveLayer& centers) {
        curves_.put({begin.x, begin.y, k}, centers);
      });
    }
    if (work_.progress) work_.progress(samples_in(begin, end));
  }

  // Reads the box of samples for the planes from grid z to the next layer of bricks. Returns the z
  // of the box after it.
  std::int32_t read_slices(std::int32_t z, GridPoint begin, GridPoint end,
                           BoxPlanes& values) const {
    const std::int32_t reach = SpectrumColumn<Real>::kReach;
    const std::int32_t slice = z - info_.margin;
    const std::int32_t next = slice < 0 ? 0 : (slice / kSlices + 1) * kSlices;
    const auto low = [&](std::int32_t cell) {
      return std::max(0, kCell * cell - reach - info_.margin);
    };
    const auto high = [&](std::int32_t cell, std::size_t axis) {
      return std::min(info_.dims[axis], kCell * cell + reach + 1 - info_.margin);
    };
    const GridPoint first = {low(begin.x), low(begin.y), std::max(0, slice)};
    const GridPoint extent =
        GridPoint{high(end.x, 0), high(end.y, 1), std::min(next, high(end.z, 2))} - first;
    if (std::min({extent.x, extent.y, extent.z}) > 0) {
      values.set(work_.samples, first, extent);
    } else {
      values.clear();
    }
    return next + info_.margin;
  }

  // Counts every sample in one cell: the cell that begins at it or contains it.
  [[nodiscard]] std::uint64_t samples_in(GridPoint begin, GridPoint end) const {
    const auto along = [&](std::int32_t from, std::int32_t to, std::int32_t last,
                           std::size_t axis) {
      const std::int32_t low = std::max(0, kCell * from - info_.margin);
      const std::int32_t high =
          to == last ? info_.dims[axis] : std::min(info_.dims[axis], kCell * to - info_.margin);
      return static_cast<std::uint64_t>(std::max(0, high - low));
    };
    return along(begin.x, end.x, data_end_.x, 0) * along(begin.y, end.y, data_end_.y, 1) *
           along(begin.z, end.z, data_end_.z, 2);
  }

  const DatasetInfo& info_;
  const Grid grid_;
  const IsovalueBins& bins_;
  const SpectrumWork& work_;
  const Cells cells_;
  const GridPoint data_end_;  // The end of all cells of the data.
  const GridPoint size_;      // The size of a column in cells.
  BrickLayout columns_;
  CurveTiles curves_;
};

// Computes a few blocks at a time and passes their bricks to the sink in order.
template <typename Real>
void make_bricks(CoarseLevel<Real>& level, int bins, const SpectrumWork& work) {
  const std::size_t fit = work.column_bytes / CoarseLevel<Real>::max_bytes(bins);
  const std::size_t at_once = std::clamp<std::size_t>(fit, 1, 2 * work.threads);
  for (std::size_t first = 0; first < level.blocks(); first += at_once) {
    std::vector<std::vector<typename CoarseLevel<Real>::Brick>> made(
        std::min(at_once, level.blocks() - first));
    work.for_each(made.size(), [&](std::size_t i) { made[i] = level.make(first + i); });
    for (const auto& bricks : made) {
      for (const auto& brick : bricks) work.sink(brick.index, brick.bytes);
    }
  }
}

// Builds the coarse levels from the curves of the cells.
template <typename Real>
void build_coarse_levels(const DatasetInfo& info, const IsovalueBins& bins,
                         const CurveSource& cells, const SpectrumWork& work) {
  const SpectrumLayout layout(info);
  std::unique_ptr<CoarseLevel<Real>> finer;
  for (const SpectrumLayout::Level& level : layout.levels()) {
    const CurveSource& below = finer ? static_cast<const CurveSource&>(finer->cubes()) : cells;
    auto coarser =
        std::make_unique<CoarseLevel<Real>>(info, bins, level, work.coarse, below, work.scratch);
    make_bricks(*coarser, bins.count(), work);
    finer = std::move(coarser);
  }
}

bool is_empty(const DatasetInfo& info, const IsovalueBins& bins) {
  return SpectrumLayout(info).size() == 0 || bins.count() == 0;
}

template <typename Real>
void build(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work) {
  FineLevels<Real> fine(info, bins, work, work.nonconstant_cells.value_or(spectrum_cells(info)));
  fine.make();
  build_coarse_levels<Real>(info, bins, fine.curves(), work);
}

template <typename Real>
CellCurves make_curves(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work,
                       const CellBox& cells) {
  FineLevels<Real> fine(info, bins, work, cells);
  fine.make();
  return {.cells = cells, .tile = fine.tile(), .tile_ranges = fine.curves().tile_ranges()};
}

// The curves of several boxes of cells.
class JoinedCurves : public CurveSource {
 public:
  explicit JoinedCurves(std::span<const SavedCurves> parts) {
    for (const SavedCurves& part : parts) {
      const CellBox& cells = part.curves.cells;
      parts_.push_back(
          {cells, CurveTiles(cells.begin, cells.end, part.curves.tile, *part.scratch)});
      parts_.back().tiles.set_tile_ranges(part.curves.tile_ranges);
    }
  }
  void get(std::int32_t k, CurveLayer& into) const override {
    for (const Part& part : parts_) part.tiles.get(k, into);
  }

 private:
  struct Part {
    CellBox cells;
    CurveTiles tiles;
  };
  std::vector<Part> parts_;
};

}  // namespace

CellBox spectrum_cells(const DatasetInfo& info) {
  const LevelExtent fine =
      level_extent(grid_of(info), first_sample(info), last_sample(info), kSpectrumExponent - 1);
  const GridPoint last = fine.low + fine.extent - GridPoint{1, 1, 1};
  return {.begin = {fine.low.x >> 1, fine.low.y >> 1, fine.low.z >> 1},
          .end = {(last.x + 1) >> 1, (last.y + 1) >> 1, (last.z + 1) >> 1}};
}

void build_spectrum(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work) {
  if (is_empty(info, bins)) return;
  is_exact_in_float(info) ? build<float>(info, bins, work) : build<double>(info, bins, work);
}

CellCurves make_cell_curves(const DatasetInfo& info, const IsovalueBins& bins,
                            const SpectrumWork& work, const CellBox& cells) {
  const GridPoint extent = cells.end - cells.begin;
  if (is_empty(info, bins) || std::min({extent.x, extent.y, extent.z}) <= 0) return {};
  return is_exact_in_float(info) ? make_curves<float>(info, bins, work, cells)
                                 : make_curves<double>(info, bins, work, cells);
}

void build_spectrum_from(const DatasetInfo& info, const IsovalueBins& bins,
                         std::span<const SavedCurves> parts, const SpectrumWork& work) {
  if (is_empty(info, bins)) return;
  std::vector<SavedCurves> filled;
  for (const SavedCurves& part : parts) {
    if (!part.curves.tile_ranges.empty()) filled.push_back(part);
  }
  const JoinedCurves cells(filled);
  is_exact_in_float(info) ? build_coarse_levels<float>(info, bins, cells, work)
                          : build_coarse_levels<double>(info, bins, cells, work);
}

}  // namespace multitetra
