#include "server/core/spectrum_builder.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "server/core/level_wavefront.hpp"
#include "server/core/spectrum_brick.hpp"
#include "server/core/spectrum_layout.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kCell = kSpectrumSpacing;
// Along x and y: the seam of a small column is a large part of it.
constexpr std::array<std::int32_t, 3> kCellsInColumn = {32, 16, 8};
constexpr int kFineLevels = kSpectrumExponent;
constexpr std::int32_t kFineRing = 4;  // A level takes the steps of a finer one as they are made;
constexpr std::int32_t kRing = 16;     // cells wait for a slab, and coarser levels for the cells.

// Grid steps around a column that its levels of spacing 1, 2 and 4 reach.
constexpr std::array<std::int32_t, kFineLevels> kSeam = {6, 4, 0};

constexpr std::int32_t floor_half(std::int32_t v) { return v >> 1; }
constexpr std::int32_t ceil_half(std::int32_t v) { return (v + 1) >> 1; }

// Values from a slab of samples; beyond the data the value outside.
class SlabPlanes : public PlaneSource {
 public:
  // Slices from grid z `first_z` on; the slab may be empty.
  SlabPlanes(const DatasetInfo& info, const Samples* slab, std::int32_t first_z,
             std::int32_t slices)
      : info_(info),
        slab_(slab),
        first_z_(first_z),
        slices_(slices),
        outside_(info.outside ? static_cast<float>(*info.outside)
                              : std::numeric_limits<float>::quiet_NaN()) {}

  void read(int exponent, GridPoint low, GridPoint extent, float* into) const override {
    const std::int32_t slice = (low.z << exponent) - first_z_;
    if (slab_ == nullptr || slice < 0 || slice >= slices_) {
      std::fill_n(into, std::ptrdiff_t{extent.x} * extent.y, outside_);
      return;
    }
    std::visit(
        [&](const auto& samples) { read(samples.data(), slice, exponent, low, extent, into); },
        *slab_);
  }

 private:
  template <typename Sample>
  void read(const Sample* samples, std::int32_t slice, int exponent, GridPoint low,
            GridPoint extent, float* into) const {
    const std::int32_t step = 1 << exponent;
    for (std::int32_t j = 0; j < extent.y; ++j, into += extent.x) {
      const std::int32_t y = (low.y + j) * step - info_.margin;
      if (y < 0 || y >= info_.dims[1]) {
        std::fill_n(into, extent.x, outside_);
        continue;
      }
      const Sample* const row =
          samples + std::ptrdiff_t{info_.dims[0]} * (y + std::ptrdiff_t{info_.dims[1]} * slice);
      for (std::int32_t i = 0; i < extent.x; ++i) {
        const std::int32_t x = (low.x + i) * step - info_.margin;
        into[i] = x < 0 || x >= info_.dims[0] ? outside_ : static_cast<float>(row[x]);
      }
    }
  }

  const DatasetInfo& info_;
  const Samples* slab_;
  std::int32_t first_z_;
  std::int32_t slices_;
  float outside_;
};

// The window of a level over cells begin ... end - 1 and a seam around them.
LevelWindow window_over_cells(const Grid& grid, GridPoint begin, GridPoint end, int exponent) {
  const std::int32_t seam = kSeam[static_cast<std::size_t>(exponent)];
  const auto low = [&](std::int32_t cell) { return std::max(0, kCell * cell - seam) >> exponent; };
  const auto high = [&](std::int32_t cell) {
    return std::min(grid.side(), kCell * cell + seam) >> exponent;
  };
  LevelWindow window{
      .exponent = exponent, .low = {low(begin.x), low(begin.y), low(begin.z)}, .extent = {}};
  window.extent =
      GridPoint{high(end.x), high(end.y), high(end.z)} - window.low + GridPoint{1, 1, 1};
  return window;
}

// The cube centres of a level's last steps, kept for the next level.
class CubeRing {
 public:
  // Keeps the last `size` steps.
  explicit CubeRing(std::int32_t size = kRing) : layers_(static_cast<std::size_t>(size)) {}

  template <typename Real>
  void take(const LevelWavefront<Real>& level, std::int32_t k) {
    Step& step = layers_[slot(k)];
    step.k = k;
    level.copy_cubes(step.cubes);
  }
  // (x, y) in the level's units.
  [[nodiscard]] FoundCurve find(std::int32_t k, std::int32_t x, std::int32_t y) const {
    if (k < 0) return {};
    const Step& step = layers_[slot(k)];
    return step.k == k ? FoundCurve{step.cubes.find(x >> 1, y >> 1), &step.cubes} : FoundCurve{};
  }

 private:
  struct Step {
    std::int32_t k = -1;
    CurveLayer cubes;
  };
  [[nodiscard]] std::size_t slot(std::int32_t k) const {
    return static_cast<std::size_t>(k) % layers_.size();
  }

  std::vector<Step> layers_;
};

// The levels of spacing 1, 2 and 4 over some cells.
template <typename Real>
class Column {
 public:
  Column(const Grid& grid, const Vec3& spacing, const IsovalueBins& bins, GridPoint begin,
         GridPoint end) {
    for (int e = 0; e < kFineLevels; ++e) {
      levels_.emplace_back(grid, spacing, bins, window_over_cells(grid, begin, end, e));
    }
  }

  // Takes the values of grid z and does what they make possible.
  void add(std::int32_t z, const PlaneSource& values) {
    for (int e = 0; e < kFineLevels; ++e) {
      LevelWavefront<Real>& level = levels_[static_cast<std::size_t>(e)];
      if (level.next_plane() << e == z) level.load_plane(values);
    }
    advance();
  }
  // The curve of the cell's centre; (x, y) in units of spacing 4.
  [[nodiscard]] FoundCurve find(std::int32_t k, std::int32_t x, std::int32_t y) const {
    return rings_[kFineLevels - 1].find(k, x, y);
  }
  [[nodiscard]] std::int32_t finished_cells() const { return levels_.back().next_step(); }

 private:
  void advance() {
    for (std::size_t e = 0; e < levels_.size(); ++e) {
      LevelWavefront<Real>& level = levels_[e];
      CubeCurve finer;
      if (e > 0) {
        finer = [this, e](std::int32_t k, std::int32_t x, std::int32_t y) {
          return rings_[e - 1].find(k, x, y);
        };
      }
      while (!level.is_done() && level.has_values() && has_finer(e, level.next_step())) {
        const std::int32_t k = level.next_step();
        level.step(finer);
        rings_[e].take(level, k);
      }
    }
  }
  [[nodiscard]] bool has_finer(std::size_t e, std::int32_t k) const {
    if (e == 0) return true;
    const LevelWavefront<Real>& finer = levels_[e - 1];
    return finer.is_done() || finer.next_step() > 2 * k + 2;
  }

  std::vector<LevelWavefront<Real>> levels_;
  std::array<CubeRing, kFineLevels> rings_ = {CubeRing(kFineRing), CubeRing(kFineRing),
                                              CubeRing(kRing)};
};

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

// Every eighth sample of the data.
class CoarseVolume : public PlaneSource {
 public:
  explicit CoarseVolume(const DatasetInfo& info)
      : info_(info), extent_(coarse_extent(info, kCell)) {
    const std::size_t size = extent_.size();
    switch (info.type) {
      case SampleType::kU8:
        samples_ = std::vector<std::uint8_t>(size);
        break;
      case SampleType::kI8:
        samples_ = std::vector<std::int8_t>(size);
        break;
      case SampleType::kU16:
        samples_ = std::vector<std::uint16_t>(size);
        break;
      case SampleType::kI16:
        samples_ = std::vector<std::int16_t>(size);
        break;
      case SampleType::kF32:
        samples_ = std::vector<float>(size);
        break;
    }
  }

  // Takes what it needs of a slab that begins with slice `first`.
  void add(const Samples& slab, std::int32_t first, std::int32_t slices) {
    std::visit(
        [&](auto& into) {
          const auto& from = std::get<std::decay_t<decltype(into)>>(slab);
          for (std::int32_t k = 0; k < extent_.dims[2]; ++k) {
            const GridPoint at = {extent_.origin.x, extent_.origin.y, extent_.origin.z + k};
            const std::int32_t slice = kCell * at.z - info_.margin - first;
            if (slice >= 0 && slice < slices) add_slice(from, slice, at, into);
          }
        },
        samples_);
  }

  void read(int exponent, GridPoint low, GridPoint extent, float* into) const override {
    const float outside = info_.outside ? static_cast<float>(*info_.outside)
                                        : std::numeric_limits<float>::quiet_NaN();
    const std::int32_t step = 1 << (exponent - kSpectrumExponent);
    std::visit(
        [&](const auto& samples) {
          for (std::int32_t j = 0; j < extent.y; ++j) {
            for (std::int32_t i = 0; i < extent.x; ++i) {
              const GridPoint p = step * (low + GridPoint{i, j, 0});
              *into++ =
                  extent_.contains(p) ? static_cast<float>(samples[extent_.index(p)]) : outside;
            }
          }
        },
        samples_);
  }

  [[nodiscard]] const Samples& samples() const { return samples_; }

 private:
  template <typename Values>
  void add_slice(const Values& slab, std::int32_t slice, GridPoint first, Values& into) const {
    for (std::int32_t j = 0; j < extent_.dims[1]; ++j) {
      for (std::int32_t i = 0; i < extent_.dims[0]; ++i) {
        const GridPoint at = first + GridPoint{i, j, 0};
        const GridPoint sample = kCell * at - GridPoint{info_.margin, info_.margin, 0};
        into[extent_.index(at)] = slab[static_cast<std::size_t>(
            sample.x +
            std::ptrdiff_t{info_.dims[0]} * (sample.y + std::ptrdiff_t{info_.dims[1]} * slice))];
      }
    }
  }

  const DatasetInfo& info_;
  CoarseExtent extent_;
  Samples samples_;
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
    rings_.resize(levels_.size());
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
        level_extent(grid_, first_sample(info_), last_sample(info_), kFineLevels - 1);
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
        columns_.push_back(std::make_unique<Column<Real>>(
            grid_, info_.spacing, bins_, GridPoint{x, y, cells_begin_.z},
            GridPoint{std::min(x + cells_in_column_, cells_end_.x),
                      std::min(y + cells_in_column_, cells_end_.y), cells_end_.z}));
      }
    }
    next_z_ = std::max(0, kCell * cells_begin_.z - kSeam[0] - 1);
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
  std::vector<std::unique_ptr<Column<Real>>> columns_;
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
