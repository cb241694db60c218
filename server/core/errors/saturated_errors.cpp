#include "server/core/errors/saturated_errors.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "server/core/errors/own_error.hpp"
#include "server/core/framework/rounding.hpp"
#include "server/core/framework/row_kinds.hpp"

namespace multitetra {
SaturatedErrors::Level SaturatedErrors::level_for(const Field& field, int exponent) {
  Level level;
  level.extent = level_extent(field.grid(), field.first_sample(), field.last_sample(), exponent);
  level.error.assign(level.extent.size(), 0.0F);
  level.flip.assign(level.extent.size(), 0);
  return level;
}

// Fills one level of the pyramid; the next finer level must be complete. All values are 0 before,
// so only points whose own error or children's errors are not 0 cost time.
template <typename Sample>
class SaturatedErrors::Pass {
 public:
  Pass(std::vector<Level>& levels, const Grid& grid, const SampledField<Sample>& field,
       const GridStepLengths& lengths, double isovalue, ErrorMeasure measure, TopologyRule rule)
      : level_(levels.back()),
        finer_(levels.size() > 1 ? &levels[levels.size() - 2] : nullptr),
        exponent_(static_cast<int>(levels.size()) - 1),
        grid_(grid),
        field_(field),
        lengths_(lengths),
        isovalue_(isovalue),
        measure_(measure),
        rule_(rule) {}

  void fill_slice(PointKind kind, std::int32_t z) const {
    const auto& [exponent, low, extent] = level_.extent;
    for (std::int32_t y = low.y; y < low.y + extent.y; ++y) {
      const RowKind& shape = row_kind(kind, y, z);
      if (!shape.exists) continue;
      const std::int32_t first = low.x + (((low.x & 1) != 0) == shape.odd_x ? 0 : 1);
      for (std::int32_t x = first; x < low.x + extent.x; x += 2) fill(shape, {x, y, z});
    }
  }

 private:
  void fill(const RowKind& shape, GridPoint unit_point) const {
    const GridPoint at = (1 << exponent_) * unit_point;
    const bool is_active = field_.is_mixed(at, 1 << exponent_, shape.diamond, isovalue_);
    const ErrorBound below = worst_child(shape, unit_point);
    if (!is_active && below.error == 0 && below.flip_spacing == 0) return;

    const OwnError own =
        is_active ? own_error(field_, grid_, lengths_, DividingPoint(at), isovalue_) : OwnError{};
    const std::size_t index = level_.extent.index(unit_point);
    level_.error[index] = measure_ == ErrorMeasure::kPaper
                              ? std::max(below.error, rounded_up(own.displacement))
                              : rounded_up(own.certified + static_cast<double>(below.error));
    const bool is_forbidden = rule_ == TopologyRule::kPaper ? own.flip : own.critical;
    const int flip_below = below.flip_spacing == 0 ? 0 : 1 + exponent_of(below.flip_spacing);
    level_.flip[index] = static_cast<std::uint8_t>(is_forbidden ? 1 + exponent_ : flip_below);
  }

  [[nodiscard]] ErrorBound worst_child(const RowKind& shape, GridPoint unit_point) const {
    const bool are_finer = shape.is_edge;
    if (are_finer && finer_ == nullptr) return {};
    const Level& level = are_finer ? *finer_ : level_;
    const GridPoint center = are_finer ? 2 * unit_point : unit_point;
    ErrorBound worst;
    for (const GridPoint offset : shape.children) {
      if (!level.extent.contains(center + offset)) continue;
      const ErrorBound child = level.bound(level.extent.index(center + offset));
      worst.error = std::max(worst.error, child.error);
      worst.flip_spacing = std::max(worst.flip_spacing, child.flip_spacing);
    }
    return worst;
  }

  Level& level_;
  const Level* finer_;  // Null at spacing 1.
  int exponent_;
  const Grid& grid_;
  const SampledField<Sample>& field_;
  const GridStepLengths& lengths_;
  double isovalue_;
  ErrorMeasure measure_;
  TopologyRule rule_;
};

SaturatedErrors::SaturatedErrors(const Field& field, double isovalue, ErrorMeasure measure,
                                 TopologyRule rule, const ForEach& for_each,
                                 std::int32_t finest_spacing) {
  const GridStepLengths lengths(field.spacing());
  field.visit([&]<typename Sample>(const SampledField<Sample>& sampled) {
    for (int exponent = 0; exponent < field.grid().exponent(); ++exponent) {
      levels_.push_back(level_for(field, exponent));
      if (1 << exponent < finest_spacing) continue;
      const Level& level = levels_.back();
      const Pass<Sample> pass(levels_, field.grid(), sampled, lengths, isovalue, measure, rule);
      for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
        for_each(static_cast<std::size_t>(level.extent.extent.z), [&](std::size_t slice) {
          pass.fill_slice(kind, level.extent.low.z + static_cast<std::int32_t>(slice));
        });
      }
    }
  });
}

ErrorBound SaturatedErrors::bound(const DividingPoint& point) const {
  const Level& level = levels_[static_cast<std::size_t>(exponent_of(point.spacing()))];
  const GridPoint unit_point = level.extent.unit_point(point.at());
  return level.extent.contains(unit_point) ? level.bound(level.extent.index(unit_point))
                                           : ErrorBound{};
}

}  // namespace multitetra
