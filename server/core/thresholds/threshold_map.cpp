#include "server/core/thresholds/threshold_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/core/thresholds/detail/region_octree.hpp"
#include "server/core/thresholds/detail/region_set.hpp"
#include "server/core/thresholds/detail/threshold_bound.hpp"
#include "server/core/thresholds/detail/threshold_pyramid.hpp"
#include "server/core/thresholds/detail/view_threshold.hpp"

namespace multitetra {
namespace {

double unit_of(const IsosurfaceRequest& request, const DatasetInfo& info) {
  return request.unit == ErrorUnit::kVoxel ? voxel_length(info) : 1.0;
}

// Converts a threshold to world units; finite even if the product overflows.
double world(double threshold, double unit) {
  return std::min(threshold * unit, std::numeric_limits<double>::max());
}

// Returns the box that the surface can occupy: the samples, and with a value outside one step more.
Box places_of(const DatasetInfo& info) {
  const double border = info.outside ? 1 : 0;
  const double side = std::int32_t{1} << info.grid_exponent;
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::max(info.margin - border, 0.0);
    box.high[axis] = std::min(info.margin + info.dims[axis] - 1 + border, side);
  }
  return box;
}

// Returns whether the squares of all mapped coordinates over the box stay finite.
bool has_finite_squares(const Affine& map, const Box& box) {
  constexpr double kMaxSafeCoordinate = 1e150;
  const Box image = image_of(map, box);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(image.low[axis] >= -kMaxSafeCoordinate && image.high[axis] <= kMaxSafeCoordinate))
      return false;
  }
  return true;
}

// The parts of a request's map, before its regions are indexed.
struct MapParts {
  MapParts(const IsosurfaceRequest& request, const DatasetInfo& info)
      : combination(request.thresholds.combination),
        everywhere(world(request.error, unit_of(request, info))),
        error_floor(world(request.thresholds.error_floor, unit_of(request, info))),
        places(places_of(info)),
        regions(request.thresholds.regions, combination,
                request.thresholds.coordinates == CoordinateSystem::kWorld ? grid_to_world(info)
                                                                           : grid_to_index(info),
                unit_of(request, info)),
        has_finite_squares(multitetra::has_finite_squares(grid_to_world(info), places)) {
    const LocalThresholds& thresholds = request.thresholds;
    if (thresholds.grid && has_finite_squares) {
      const Affine to_samples =
          composed(inverse(thresholds.grid->index_to_world), grid_to_world(info));
      has_finite_squares = multitetra::has_finite_squares(to_samples, places);
      if (has_finite_squares) grid.emplace(*thresholds.grid, to_samples, unit_of(request, info));
    }
    if (thresholds.view && has_finite_squares) {
      const bool is_in_world = thresholds.coordinates == CoordinateSystem::kWorld;
      view.emplace(is_in_world ? *thresholds.view : in_world(*thresholds.view, info.index_to_world),
                   grid_to_world(info), unit_of(request, info));
    }
  }

  // A part that is defined everywhere bounds the result: in order, it hides the parts after it; for
  // the minimum, it is an upper bound.
  [[nodiscard]] double largest() const {
    constexpr double kNothing = std::numeric_limits<double>::infinity();
    if (!has_finite_squares) return error_floor;
    const RegionSet::List list = regions.relevant(regions.all(), places);
    double of_regions = 0;
    for (const RegionSet::Index i : list.regions) {
      of_regions = std::max(of_regions, regions.threshold(i));
    }
    const double of_grid = grid ? grid->largest_in(places) : 0;
    const bool is_grid_whole = grid && !grid->least_in(places).has_gap;
    const double of_view = view ? view->largest_in(places) : 0;
    if (combination == Combination::kMinimum) {
      const double whole =
          std::min({list.is_closed ? of_regions : kNothing, is_grid_whole ? of_grid : kNothing,
                    view ? of_view : kNothing});
      const double any = std::max({of_regions, of_grid, of_view, everywhere});
      return std::max(std::min(whole, any), error_floor);
    }
    double largest = of_regions;
    if (!list.is_closed) {
      largest = std::max(largest, view            ? of_view
                                  : is_grid_whole ? of_grid
                                                  : std::max(of_grid, everywhere));
    }
    return std::max(largest, error_floor);
  }

  Combination combination;
  double everywhere;
  double error_floor;
  Box places;
  RegionSet regions;
  std::optional<ThresholdPyramid> grid;
  std::optional<ViewThreshold> view;
  // If not set, the map is `error_floor` everywhere.
  bool has_finite_squares;
};

}  // namespace

struct ThresholdMap::IndexedParts {
  IndexedParts(MapParts parts, int grid_exponent, const std::function<void()>& check)
      : pieces(std::move(parts)),
        regions(std::move(pieces.regions), pieces.places, grid_exponent, check) {}

  [[nodiscard]] double least_in(const Box& box) const {
    const Box places = clamped(box, pieces.places);
    const double least =
        pieces.combination == Combination::kInOrder ? least_in_order(places) : least_of_all(places);
    return std::max(least, pieces.error_floor);
  }

  // Regions hide the view, the view hides the grid, and the grid hides the threshold everywhere.
  [[nodiscard]] double least_in_order(const Box& box) const {
    const ThresholdBound by_regions = regions.least_in(box);
    if (!by_regions.has_gap) return by_regions.least;
    if (pieces.view) return std::min(by_regions.least, pieces.view->least_in(box));
    const ThresholdBound by_grid =
        pieces.grid ? pieces.grid->least_in(box) : ThresholdBound{.has_gap = true};
    const double least = std::min(by_regions.least, by_grid.least);
    return by_grid.has_gap ? std::min(least, pieces.everywhere) : least;
  }

  [[nodiscard]] double least_of_all(const Box& box) const {
    const ThresholdBound by_regions = regions.least_in(box);
    double least = by_regions.least;
    bool has_gap = by_regions.has_gap && !pieces.view;
    if (pieces.view) least = std::min(least, pieces.view->least_in(box));
    if (pieces.grid) {
      const ThresholdBound by_grid = pieces.grid->least_in(box);
      least = std::min(least, by_grid.least);
      has_gap = has_gap && by_grid.has_gap;
    }
    return has_gap ? std::min(least, pieces.everywhere) : least;
  }

  // Its regions have been moved into the octree.
  MapParts pieces;
  RegionOctree regions;
};

ThresholdMap::ThresholdMap(const IsosurfaceRequest& request, const DatasetInfo& info,
                           const std::function<void()>& check) {
  if (request.thresholds.is_uniform()) {
    const double unit = unit_of(request, info);
    least_ = largest_ =
        std::max(world(request.error, unit), world(request.thresholds.error_floor, unit));
    return;
  }
  MapParts pieces(request, info);
  largest_ = pieces.largest();
  if (!pieces.has_finite_squares) {
    least_ = largest_;
    return;
  }
  auto parts = std::make_shared<const IndexedParts>(std::move(pieces), info.grid_exponent, check);
  least_ = parts->least_in(parts->pieces.places);
  if (least_ != largest_) parts_ = std::move(parts);
}

double ThresholdMap::least_of_parts(const Box& box) const { return parts_->least_in(box); }

double largest_threshold(const IsosurfaceRequest& request, const DatasetInfo& info) {
  return request.thresholds.is_uniform() ? ThresholdMap(request, info).largest()
                                         : MapParts(request, info).largest();
}

}  // namespace multitetra
