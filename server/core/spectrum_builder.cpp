#include "server/core/spectrum_builder.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "server/core/plane_sources.hpp"
#include "server/core/spectrum_brick.hpp"
#include "server/core/spectrum_column.hpp"
#include "server/core/spectrum_layout.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kCell = kSpectrumSpacing;
// Along x and y: the seam of a small column is a large part of it.
constexpr std::array<std::int32_t, 3> kCellsInColumn = {32, 16, 8};
constexpr std::int32_t kStepsKept = 16;  // Of a coarser level, until the next one takes them.

constexpr std::int32_t floor_half(std::int32_t v) { return v >> 1; }
constexpr std::int32_t ceil_half(std::int32_t v) { return (v + 1) >> 1; }

// The bricks of one level that are being filled: one layer of them.
class BrickLayer {
 public:
  BrickLayer(const SpectrumLayout::Level& level, float voxel)
      : level_(level), voxel_(voxel), builders_(bricks_in_layer()) {}

  // The points of layer z (units) that have exactly this level's spacing.
  void add(std::int32_t z, const CurveLayer& layer) {
    const GridPoint low = level_.extent.low;
    for (std::int32_t y = low.y; y < low.y + level_.extent.extent.y; ++y) {
      for (std::int32_t x = low.x; x < low.x + level_.extent.extent.x; ++x) {
        const CurveLayer::Curve curve = layer.find(x, y);
        if (curve.count == 0) continue;
        const auto place = SpectrumLayout::place(level_, {x, y, z});
        builders_[(place.brick - level_.first_brick) % builders_.size()].add(
            place.point, layer.blocks(curve), curve, voxel_);
      }
    }
  }
  // Whether z is the last layer of points in its layer of bricks.
  [[nodiscard]] bool ends_with(std::int32_t z) const {
    const std::int32_t at = z - level_.extent.low.z;
    return at % SpectrumLayout::kSide == SpectrumLayout::kSide - 1 ||
           at == level_.extent.extent.z - 1;
  }
  void flush(std::int32_t z, const SpectrumBuilder::Sink& sink, const ForEach& for_each) {
    const std::size_t first =
        level_.first_brick + builders_.size() * static_cast<std::size_t>((z - level_.extent.low.z) /
                                                                         SpectrumLayout::kSide);
    std::vector<std::vector<std::byte>> bytes(builders_.size());
    for_each(builders_.size(), [&](std::size_t i) { bytes[i] = builders_[i].take(); });
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (!bytes[i].empty()) sink(first + i, bytes[i]);
    }
  }

 private:
  [[nodiscard]] std::size_t bricks_in_layer() const {
    return static_cast<std::size_t>(level_.bricks.counts()[0]) *
           static_cast<std::size_t>(level_.bricks.counts()[1]);
  }

  const SpectrumLayout::Level& level_;
  float voxel_;
  std::vector<SpectrumBrickBuilder> builders_;
};

bool is_exact_in_float(const DatasetInfo& info) {
  const double outside = info.outside.value_or(0);
  return info.type != SampleType::kF32 && outside == std::floor(outside) &&
         std::abs(outside) <= 65536;
}

}  // namespace

class SpectrumBuilder::Work {
 public:
  virtual ~Work() = default;
  virtual void add(const Samples& slab, std::int32_t slices) = 0;
  virtual void finish() = 0;
  [[nodiscard]] virtual const Samples& coarse_samples() const = 0;
};

template <typename Real>
class SpectrumBuilder::TypedWork : public Work {
 public:
  TypedWork(const DatasetInfo& info, IsovalueBins bins, Sink sink, ForEach for_each,
            std::size_t least_columns)
      : info_(info),
        grid_(grid_of(info_)),
        bins_(std::move(bins)),
        sink_(std::move(sink)),
        for_each_(std::move(for_each)),
        layout_(info_),
        coarse_(info_) {
    if (layout_.size() == 0 || bins_.count() == 0) return;
    make_columns(least_columns);
    for (const SpectrumLayout::Level& level : layout_.levels()) {
      levels_.emplace_back(grid_, info_.spacing, bins_, window_of(level));
      brick_layers_.emplace_back(level, static_cast<float>(voxel_length(info_)));
    }
    rings_.assign(levels_.size(), CubeRing(kStepsKept));
  }

  void add(const Samples& slab, std::int32_t slices) override {
    coarse_.add(slab, next_slice_, slices);
    const std::int32_t z = info_.margin + next_slice_;
    next_slice_ += slices;
    if (columns_.empty()) return;
    run_columns(z, nullptr, 0);  // What lies before the data.
    run_columns(z + slices, &slab, slices);
    advance();
  }

  void finish() override {
    assert(next_slice_ == info_.dims[2]);
    if (columns_.empty()) return;
    const std::int32_t end = std::min(grid_.side(), kCell * cells_end_.z + 8) + 1;
    while (next_z_ < end) {
      run_columns(std::min(end, next_z_ + 16), nullptr, 0);
      advance();
    }
    assert(std::all_of(levels_.begin(), levels_.end(), [](const auto& l) { return l.is_done(); }));
  }

  [[nodiscard]] const Samples& coarse_samples() const override { return coarse_.samples(); }

 private:
  void make_columns(std::size_t least_columns) {
    const LevelExtent fine =
        level_extent(grid_, first_sample(info_), last_sample(info_), kSpectrumExponent - 1);
    const GridPoint last = fine.low + fine.extent - GridPoint{1, 1, 1};
    cells_begin_ = {floor_half(fine.low.x), floor_half(fine.low.y), floor_half(fine.low.z)};
    cells_end_ = {ceil_half(last.x), ceil_half(last.y), ceil_half(last.z)};
    const GridPoint cells = cells_end_ - cells_begin_;
    for (const std::int32_t size : kCellsInColumn) {
      const auto along = [size](std::int32_t count) { return (count + size - 1) / size; };
      cells_in_column_ = size;
      if (static_cast<std::size_t>(along(cells.x) * along(cells.y)) >= least_columns) break;
    }
    for (std::int32_t y = cells_begin_.y; y < cells_end_.y; y += cells_in_column_) {
      columns_in_row_ = 0;
      for (std::int32_t x = cells_begin_.x; x < cells_end_.x; x += cells_in_column_) {
        ++columns_in_row_;
        columns_.push_back(std::make_unique<SpectrumColumn<Real>>(
            grid_, info_.spacing, bins_, GridPoint{x, y, cells_begin_.z},
            GridPoint{std::min(x + cells_in_column_, cells_end_.x),
                      std::min(y + cells_in_column_, cells_end_.y), cells_end_.z}));
      }
    }
    next_z_ = std::max(0, kCell * cells_begin_.z - 7);  // Six steps and a diamond.
  }

  static LevelWindow window_of(const SpectrumLayout::Level& level) {
    LevelWindow window{
        .exponent = level.extent.exponent, .low = level.extent.low, .extent = level.extent.extent};
    const std::int32_t odd = window.low.z & 1;
    window.low.z -= odd;
    window.extent.z += odd;
    return window;
  }

  // Lets all columns take the values up to grid z `end`.
  void run_columns(std::int32_t end, const Samples* slab, std::int32_t slices) {
    if (next_z_ >= end) return;
    const SlabPlanes values(info_, slab, end - slices, slices);
    for_each_(columns_.size(), [&](std::size_t i) {
      for (std::int32_t z = next_z_; z < end; ++z) columns_[i]->add(z, values);
    });
    next_z_ = end;
  }

  [[nodiscard]] FoundCurve find_cell(std::int32_t k, std::int32_t x, std::int32_t y) const {
    const std::int32_t cell_x = floor_half(x) - cells_begin_.x;
    const std::int32_t cell_y = floor_half(y) - cells_begin_.y;
    if (cell_x < 0 || cell_y < 0 || floor_half(x) >= cells_end_.x ||
        floor_half(y) >= cells_end_.y) {
      return {};
    }
    const std::int32_t column =
        cell_x / cells_in_column_ + columns_in_row_ * (cell_y / cells_in_column_);
    return columns_[static_cast<std::size_t>(column)]->find(k, x, y);
  }

  // Coarser levels, as far as the cells that are done allow.
  void advance() {
    const std::int32_t cells = columns_.front()->finished_cells();
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      LevelWavefront<Real>& level = levels_[i];
      const CubeCurve finer = [this, i](std::int32_t k, std::int32_t x, std::int32_t y) {
        return i == 0 ? find_cell(k, x, y) : rings_[i - 1].find(k, x, y);
      };
      const std::int32_t available = i == 0 ? cells : levels_[i - 1].next_step();
      const bool is_last = i == 0 ? cells >= cells_end_.z : levels_[i - 1].is_done();
      while (!level.is_done() && (is_last || available > 2 * level.next_step() + 2)) {
        while (!level.has_values()) level.load_plane(coarse_);
        const std::int32_t k = level.next_step();
        level.step(finer);
        write_layers(i, k);
        rings_[i].take(level, k);
      }
    }
  }

  void write_layers(std::size_t i, std::int32_t k) {
    const LevelWavefront<Real>& level = levels_[i];
    const auto write = [&](std::int32_t z, const CurveLayer& layer) {
      const LevelExtent& extent = layout_.levels()[i].extent;
      if (z < extent.low.z || z >= extent.low.z + extent.extent.z) return;
      brick_layers_[i].add(z, layer);
      if (brick_layers_[i].ends_with(z)) brick_layers_[i].flush(z, sink_, for_each_);
    };
    write(2 * k, level.lower());
    write(2 * k + 1, level.middle());
    if (level.is_done()) write(2 * k + 2, level.upper());
  }

  const DatasetInfo info_;
  const Grid grid_;
  const IsovalueBins bins_;
  const Sink sink_;
  const ForEach for_each_;
  const SpectrumLayout layout_;
  CoarseVolume coarse_;
  GridPoint cells_begin_;
  GridPoint cells_end_;
  std::int32_t cells_in_column_ = 0;
  std::int32_t columns_in_row_ = 0;
  std::vector<std::unique_ptr<SpectrumColumn<Real>>> columns_;
  std::vector<LevelWavefront<Real>> levels_;
  std::vector<CubeRing> rings_;
  std::vector<BrickLayer> brick_layers_;
  std::int32_t next_slice_ = 0;
  std::int32_t next_z_ = 0;  // Of the values that the columns take next.
};

SpectrumBuilder::SpectrumBuilder(const DatasetInfo& info, IsovalueBins bins, Sink sink,
                                 ForEach for_each, std::size_t least_columns) {
  if (is_exact_in_float(info)) {
    work_ = std::make_unique<TypedWork<float>>(info, std::move(bins), std::move(sink),
                                               std::move(for_each), least_columns);
  } else {
    work_ = std::make_unique<TypedWork<double>>(info, std::move(bins), std::move(sink),
                                                std::move(for_each), least_columns);
  }
}
SpectrumBuilder::~SpectrumBuilder() = default;

void SpectrumBuilder::add(const Samples& slab, std::int32_t slices) { work_->add(slab, slices); }
void SpectrumBuilder::finish() { work_->finish(); }
const Samples& SpectrumBuilder::coarse_samples() const { return work_->coarse_samples(); }

}  // namespace multitetra
