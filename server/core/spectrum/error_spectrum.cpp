#include "server/core/spectrum/error_spectrum.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "server/core/errors/error_based_model.hpp"
#include "server/core/errors/saturated_errors.hpp"
#include "server/core/spectrum/detail/error_codes.hpp"
#include "server/core/spectrum/detail/spectrum_brick.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

template <typename Visit>
void for_each_cube(const LevelExtent& extent, const Visit& visit) {
  const GridPoint end = extent.low + extent.extent;
  for (std::int32_t z = extent.low.z; z < end.z; ++z) {
    for (std::int32_t y = extent.low.y; y < end.y; ++y) {
      for (std::int32_t x = extent.low.x; x < end.x; ++x) visit(GridPoint{x, y, z});
    }
  }
}

}  // namespace

// Bounds of the errors of a volume whose spectrum is missing, for one isovalue, from the ranges of
// its cells.
//
// The values that decide the errors of a point p and of its descendants lie in the box B(p)
// (region() in error_based_model.hpp). If all of them are on one side of the isovalue, these errors
// are 0; otherwise they are unknown: infinite, with a flip of p's own spacing. B of a child lies
// inside B of its parents, so bounds never decrease from children to parents, and models conform.
// Thread-safe. Takes two bytes per cell.
class UnknownErrors {
 public:
  UnknownErrors(const PreparedVolume& volume, double isovalue)
      : isovalue_(isovalue),
        layout_(volume.info),
        found_(layout_.size() * SpectrumLayout::kPoints) {
    if (volume.info.outside) outside_ = sides_of(static_cast<double>(outside_value(volume.info)));
    visit_type(volume.info.type,
               [&]<typename Sample>(const Sample*) { add_cells<Sample>(volume); });
    while (levels_.back().extent.exponent + 1 < volume.info.grid_exponent) add_coarser_level();
  }

  // Requires point.spacing() >= kSpectrumSpacing.
  [[nodiscard]] ErrorBound bound(const DividingPoint& point) const {
    const SpectrumLayout::Level& level = layout_.level(exponent_of(point.spacing()));
    const GridPoint unit_point = level.extent.unit_point(point.at());
    if (!level.extent.contains(unit_point)) return {};
    const SpectrumLayout::Place place = SpectrumLayout::place(level, unit_point);
    std::atomic<std::uint8_t>& found = found_[place.brick * SpectrumLayout::kPoints + place.point];
    std::uint8_t state = found.load(std::memory_order_relaxed);
    if (state == 0) {  // Threads that compute it at once find the same.
      state = sides_in(point) == kBoth ? 2 : 1;
      found.store(state, std::memory_order_relaxed);
    }
    if (state == 1) return {};
    return {.error = std::numeric_limits<float>::infinity(), .flip_spacing = point.spacing()};
  }

 private:
  // The sides of the isovalue on which a cube has values; void values are on neither.
  using Sides = std::uint8_t;
  static constexpr Sides kAbove = 1;
  static constexpr Sides kNotAbove = 2;
  static constexpr Sides kBoth = kAbove | kNotAbove;

  struct Level {
    LevelExtent extent;  // The cubes of side 2^exponent that contain data.
    std::vector<Sides> sides;
  };
  [[nodiscard]] Sides sides_of(double value) const {
    return value > isovalue_ ? kAbove : kNotAbove;
  }
  template <typename Sample>
  void add_cells(const PreparedVolume& volume) {
    Level level{.extent = cell_extent(volume.info), .sides = {}};
    level.sides.reserve(level.extent.size());
    const std::byte* range = volume.ranges.bytes().data();
    const GridPoint first = first_sample(volume.info);
    const GridPoint last = last_sample(volume.info);
    const auto is_beyond = [&](std::int32_t cell, int axis) {
      const std::int32_t low = kSpectrumSpacing * cell;
      return low < first[axis] || low + kSpectrumSpacing > last[axis];
    };
    for_each_cube(level.extent, [&](GridPoint cell) {
      std::array<Sample, 2> ends;  // The least is larger than the largest if all are void.
      std::memcpy(ends.data(), range, sizeof(ends));
      range += sizeof(ends);
      Sides sides = 0;
      if (!(ends[0] > ends[1])) {
        sides = sides_of(static_cast<double>(ends[0])) | sides_of(static_cast<double>(ends[1]));
      }
      if (is_beyond(cell.x, 0) || is_beyond(cell.y, 1) || is_beyond(cell.z, 2)) sides |= outside_;
      level.sides.push_back(sides);
    });
    levels_.push_back(std::move(level));
  }
  void add_coarser_level() {
    const Level& finer = levels_.back();
    const GridPoint low = finer.extent.low;
    const GridPoint last = low + finer.extent.extent - GridPoint{1, 1, 1};
    const GridPoint coarse_low = {low.x >> 1, low.y >> 1, low.z >> 1};
    Level level{.extent = {.exponent = finer.extent.exponent + 1,
                           .low = coarse_low,
                           .extent = GridPoint{last.x >> 1, last.y >> 1, last.z >> 1} - coarse_low +
                                     GridPoint{1, 1, 1}},
                .sides = {}};
    level.sides.reserve(level.extent.size());
    for_each_cube(level.extent, [&](GridPoint cube) {
      Sides sides = 0;
      for (int child = 0; child < 8; ++child) {
        const GridPoint at = 2 * cube + GridPoint{child & 1, child >> 1 & 1, child >> 2};
        sides |= finer.extent.contains(at) ? finer.sides[finer.extent.index(at)] : outside_;
      }
      level.sides.push_back(sides);
    });
    levels_.push_back(std::move(level));
  }
  // The corners of B(p) are multiples of the point's spacing, so cubes of that side fill it.
  [[nodiscard]] Sides sides_in(const DividingPoint& point) const {
    const int exponent = exponent_of(point.spacing());
    const Level& level = levels_[static_cast<std::size_t>(exponent - kSpectrumExponent)];
    const Box box = region(point);
    LevelExtent cubes{.exponent = exponent, .low = {}, .extent = {}};  // Those with data.
    bool is_beyond = false;
    const auto clip = [&](std::size_t axis, std::int32_t low, std::int32_t count) {
      const auto begin = static_cast<std::int32_t>(box.low[axis]) >> exponent;
      const auto end = static_cast<std::int32_t>(box.high[axis]) >> exponent;
      is_beyond = is_beyond || begin < low || end > low + count;
      const std::int32_t first = std::max(begin, low);
      return std::pair(first, std::min(end, low + count) - first);
    };
    const auto& [unused, low, extent] = level.extent;
    std::tie(cubes.low.x, cubes.extent.x) = clip(0, low.x, extent.x);
    std::tie(cubes.low.y, cubes.extent.y) = clip(1, low.y, extent.y);
    std::tie(cubes.low.z, cubes.extent.z) = clip(2, low.z, extent.z);
    Sides sides = is_beyond ? outside_ : Sides{0};
    for_each_cube(cubes, [&](GridPoint cube) { sides |= level.sides[level.extent.index(cube)]; });
    return sides;
  }

  double isovalue_;
  Sides outside_ = 0;  // Of the value beyond the data.
  SpectrumLayout layout_;
  std::vector<Level> levels_;  // From cells of side kSpectrumSpacing on.
  // By place in the layout: 0 until first use, 1 without errors, 2 unknown.
  mutable std::vector<std::atomic<std::uint8_t>> found_;
};

std::shared_ptr<const UnknownErrors> LatestUnknownErrors::of(const PreparedVolume& volume,
                                                             double isovalue) {
  const std::lock_guard lock(mutex_);
  if (!errors_ || isovalue_ != isovalue) {
    errors_ = std::make_shared<const UnknownErrors>(volume, isovalue);
    isovalue_ = isovalue;
  }
  return errors_;
}

SpectrumErrors::SpectrumErrors(const PreparedVolume& volume, double isovalue, ErrorMeasure measure,
                               TopologyRule rule)
    : spectrum_(volume.spectrum),
      unknown_(spectrum_.bricks ? nullptr : spectrum_.unknown->of(volume, isovalue)),
      bin_(spectrum_.bins.bin_of(isovalue)),
      measure_(measure),
      rule_(rule),
      planes_(spectrum_.layout.size()) {
  for (std::size_t code = 1; code < error_of_code_.size(); ++code) {
    const float value = error_codes().value(static_cast<std::uint8_t>(code)) * spectrum_.voxel;
    error_of_code_[code] = std::nextafter(value, std::numeric_limits<float>::infinity());
  }
}

SpectrumErrors::~SpectrumErrors() {
  for (const auto& plane : planes_) delete plane.load(std::memory_order_relaxed);
}

ErrorBound SpectrumErrors::bound(const DividingPoint& point) const {
  if (!bin_) return {};
  if (unknown_) return unknown_->bound(point);
  const SpectrumLayout::Level& level = spectrum_.layout.level(exponent_of(point.spacing()));
  const GridPoint unit_point = level.extent.unit_point(point.at());
  if (!level.extent.contains(unit_point)) return {};
  const SpectrumLayout::Place place = SpectrumLayout::place(level, unit_point);
  const Plane& p = plane(place.brick);
  return {.error = error_of_code_[p.error[place.point]],
          .flip_spacing = (1 << p.flip[place.point]) >> 1};
}

const SpectrumErrors::Plane& SpectrumErrors::plane(std::size_t brick) const {
  if (const Plane* known = planes_[brick].load(std::memory_order_acquire)) return *known;
  const auto decoded = decode_plane(spectrum_.bricks->brick(brick), *bin_);
  if (!decoded) throw DamagedSpectrumError(decoded.error().text);
  auto made = std::make_unique<Plane>();
  for (std::size_t i = 0; i < SpectrumLayout::kPoints; ++i) {
    const SpectrumPlane::Point& point = decoded->points[i];
    made->error[i] = measure_ == ErrorMeasure::kPaper ? point.paper : point.certified;
    made->flip[i] = rule_ == TopologyRule::kPaper ? point.flips & 15 : point.flips >> 4;
  }
  const Plane* expected = nullptr;  // If another thread was faster, its plane is the same.
  if (planes_[brick].compare_exchange_strong(expected, made.get(), std::memory_order_acq_rel)) {
    return *made.release();
  }
  return *expected;
}

}  // namespace multitetra
