#include "server/core/saturated_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace multitetra {
namespace {

constexpr std::int32_t floor_shift(std::int32_t value, int exponent) { return value >> exponent; }
constexpr std::int32_t ceil_shift(std::int32_t value, int exponent) {
  return -((-value) >> exponent);
}

float rounded_up(double value) {
  const float nearest = static_cast<float>(value);
  return static_cast<double>(nearest) >= value
             ? nearest
             : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

}  // namespace

bool SaturatedErrors::Level::contains(GridPoint unit_point) const {
  const GridPoint at = unit_point - low;
  return at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < extent.x && at.y < extent.y &&
         at.z < extent.z;
}

std::size_t SaturatedErrors::Level::index(GridPoint unit_point) const {
  const GridPoint at = unit_point - low;
  return static_cast<std::size_t>(at.x) +
         static_cast<std::size_t>(extent.x) *
             (static_cast<std::size_t>(at.y) +
              static_cast<std::size_t>(extent.y) * static_cast<std::size_t>(at.z));
}

SaturatedErrors::SaturatedErrors(const Field& field, double isovalue, ErrorMeasure measure,
                                 TopologyRule rule, const ForEach& for_each) {
  const Grid& grid = field.grid();
  const StepLengths lengths(field.spacing());
  for (int exponent = 0; exponent < grid.exponent(); ++exponent) {
    const std::int32_t last = grid.side() >> exponent;
    const auto low = [&](std::int32_t v) { return std::max(0, floor_shift(v, exponent) - 3); };
    const auto high = [&](std::int32_t v) { return std::min(last, ceil_shift(v, exponent) + 3); };
    const GridPoint first_sample = field.first_sample();
    const GridPoint last_sample = field.last_sample();
    Level level;
    level.low = {low(first_sample.x), low(first_sample.y), low(first_sample.z)};
    level.extent = GridPoint{high(last_sample.x), high(last_sample.y), high(last_sample.z)} -
                   level.low + GridPoint{1, 1, 1};
    const std::size_t size = static_cast<std::size_t>(level.extent.x) *
                             static_cast<std::size_t>(level.extent.y) *
                             static_cast<std::size_t>(level.extent.z);
    level.error.assign(size, 0.0F);
    level.flip.assign(size, 0);
    levels_.push_back(std::move(level));

    for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
      for_each(static_cast<std::size_t>(levels_.back().extent.z), [&](std::size_t slice) {
        field.visit([&](const auto& sampled) {
          fill(sampled, grid, lengths, exponent, kind, static_cast<std::int32_t>(slice), isovalue,
               measure, rule);
        });
      });
    }
  }
}

template <typename Sample>
void SaturatedErrors::fill(const SampledField<Sample>& field, const Grid& grid,
                           const StepLengths& lengths, int exponent, PointKind kind,
                           std::int32_t slice, double isovalue, ErrorMeasure measure,
                           TopologyRule rule) {
  Level& level = levels_[static_cast<std::size_t>(exponent)];
  const std::int32_t z = level.low.z + slice;
  const auto odd_axes = kind == PointKind::kEdge ? 1 : kind == PointKind::kFace ? 2 : 3;
  for (std::int32_t y = level.low.y; y < level.low.y + level.extent.y; ++y) {
    // The parity of x follows from the kind and the other two.
    const int odd_yz = (y & 1) + (z & 1);
    if (odd_axes - odd_yz < 0 || odd_axes - odd_yz > 1) continue;
    const std::int32_t x_parity = odd_axes - odd_yz;
    std::int32_t x = level.low.x + ((level.low.x & 1) == x_parity ? 0 : 1);
    for (; x < level.low.x + level.extent.x; x += 2) {
      const DividingPoint point((1 << exponent) * GridPoint{x, y, z});
      const OwnError own = own_error(field, grid, lengths, point, isovalue);

      ErrorBound below;
      for (const GridPoint child : point.children(grid)) {
        const ErrorBound bound_of_child = bound(DividingPoint(child));
        below.error = std::max(below.error, bound_of_child.error);
        below.flip_spacing = std::max(below.flip_spacing, bound_of_child.flip_spacing);
      }
      const std::size_t at = level.index({x, y, z});
      level.error[at] = measure == ErrorMeasure::kPaper
                            ? std::max(below.error, rounded_up(own.displacement))
                            : rounded_up(own.certified + static_cast<double>(below.error));
      const bool forbidden = rule == TopologyRule::kPaper ? own.flip : own.critical;
      int flip = 0;
      while (below.flip_spacing >> flip != 0) ++flip;
      level.flip[at] = static_cast<std::uint8_t>(forbidden ? exponent + 1 : flip);
    }
  }
}

ErrorBound SaturatedErrors::bound(const DividingPoint& point) const {
  int exponent = 0;
  while ((1 << exponent) < point.spacing()) ++exponent;
  const Level& level = levels_[static_cast<std::size_t>(exponent)];
  const GridPoint p = point.at();
  const GridPoint unit_point = {p.x >> exponent, p.y >> exponent, p.z >> exponent};
  if (!level.contains(unit_point)) return {};
  const std::size_t at = level.index(unit_point);
  return {level.error[at], (1 << level.flip[at]) >> 1};
}

std::size_t SaturatedErrors::bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : levels_)
    bytes += level.error.size() * sizeof(float) + level.flip.size();
  return bytes;
}

}  // namespace multitetra
