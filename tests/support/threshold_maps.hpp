// Random threshold maps, and their values by definition.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "tests/support/fields.hpp"

namespace multitetra::testing {

inline double between(double low, double high, std::mt19937_64& random) {
  return low + (high - low) * fields::uniform(random);
}

// Returns a rotated, sheared or mirrored map with steps of about `step`.
inline Affine random_affine(double step, std::mt19937_64& random) {
  Affine map;
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      map.columns[column][row] = step * ((column == row ? 1 : 0) + between(-0.4, 0.4, random));
    }
  }
  if (random() % 2 == 0) std::swap(map.columns[0], map.columns[1]);
  for (double& number : map.translation) number = between(-100, 100, random);
  return map;
}

// Returns a place among the samples or slightly outside, in the map's coordinates.
inline Vec3 random_place(const DatasetInfo& info, CoordinateSystem coordinates,
                         std::mt19937_64& random) {
  Vec3 index;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    index[axis] = between(-0.2, 1.2, random) * info.dims[axis];
  }
  return coordinates == CoordinateSystem::kIndex ? index : info.index_to_world(index);
}

inline ThresholdRegion random_region(const DatasetInfo& info, CoordinateSystem coordinates,
                                     double size, std::mt19937_64& random) {
  const Vec3 place = random_place(info, coordinates, random);
  const double length = size * (coordinates == CoordinateSystem::kIndex ? 1 : voxel_length(info));
  ThresholdRegion region{.threshold = between(0, 4, random)};
  switch (random() % 3) {
    case 0: {
      BoxShape box{.low = place, .high = place};
      for (double& number : box.high) number += between(0, 2 * length, random);
      region.shape = box;
      break;
    }
    case 1:
      region.shape = BallShape{.center = place, .radius = between(0, length, random)};
      break;
    default: {
      const Vec3 normal = {between(-1, 1, random), between(-1, 1, random), between(-1, 1, random)};
      const double offset = normal[0] * place[0] + normal[1] * place[1] + normal[2] * place[2];
      region.shape = HalfSpaceShape{.normal = normal, .offset = offset};
    }
  }
  return region;
}

inline ThresholdGrid random_grid(const DatasetInfo& info, std::mt19937_64& random) {
  ThresholdGrid grid;
  std::size_t samples = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.dims[axis] = 1 + static_cast<std::int32_t>(random() % 7);
    samples *= static_cast<std::size_t>(grid.dims[axis]);
  }
  // Covers most of the data, slightly rotated.
  grid.index_to_world = random_affine(1, random);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) {
      grid.index_to_world.columns[axis][row] =
          info.index_to_world.columns[axis][row] * info.dims[axis] / grid.dims[axis] +
          0.1 * grid.index_to_world.columns[axis][row];
    }
  }
  grid.index_to_world.translation = info.index_to_world({1.5, 2.5, -1.5});
  for (std::size_t i = 0; i < samples; ++i) {
    grid.thresholds.push_back(random() % 5 == 0 ? std::nanf("")
                                                : static_cast<float>(between(0, 3, random)));
  }
  return grid;
}

inline ThresholdView random_view(const DatasetInfo& info, CoordinateSystem coordinates,
                                 std::mt19937_64& random) {
  ThresholdView view{.eye = random_place(info, coordinates, random),
                     .field_of_view = between(10, 120, random),
                     .height_pixels = 400,
                     .tolerance_pixels = between(5, 60, random)};
  if (random() % 2 == 0) {
    view.frustum = Frustum{.look_at = random_place(info, coordinates, random),
                           .up = {between(-1, 1, random), between(-1, 1, random), 1},
                           .aspect = between(0.5, 2, random),
                           .outside = between(0, 4, random)};
  }
  return view;
}

inline LocalThresholds random_thresholds(const DatasetInfo& info, std::mt19937_64& random) {
  LocalThresholds thresholds;
  thresholds.coordinates = random() % 2 == 0 ? CoordinateSystem::kWorld : CoordinateSystem::kIndex;
  thresholds.combination = random() % 2 == 0 ? Combination::kInOrder : Combination::kMinimum;
  const std::size_t regions = random() % 2 == 0 ? random() % 4 : random() % 40;
  for (std::size_t i = 0; i < regions; ++i) {
    thresholds.regions.push_back(random_region(info, thresholds.coordinates, 8, random));
  }
  if (random() % 2 == 0) {
    thresholds.grid = std::make_shared<const ThresholdGrid>(random_grid(info, random));
  }
  if (random() % 3 == 0) thresholds.view = random_view(info, thresholds.coordinates, random);
  if (random() % 3 == 0) thresholds.error_floor = between(0, 1, random);
  return thresholds;
}

// ---- the definition

inline bool contains_place(const ThresholdRegion& region, const Vec3& x) {
  if (const auto* box = std::get_if<BoxShape>(&region.shape)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (x[axis] < box->low[axis] || x[axis] > box->high[axis]) return false;
    }
    return true;
  }
  if (const auto* ball = std::get_if<BallShape>(&region.shape)) {
    const Vec3& c = ball->center;
    return std::hypot(x[0] - c[0], x[1] - c[1], x[2] - c[2]) <= ball->radius;
  }
  const auto& half_space = std::get<HalfSpaceShape>(region.shape);
  const Vec3& n = half_space.normal;
  return n[0] * x[0] + n[1] * x[1] + n[2] * x[2] >= half_space.offset;
}

// Returns the least threshold of the voxels that contain the world place; nullopt if there is none.
inline std::optional<double> grid_says(const ThresholdGrid& grid, const Vec3& world) {
  const Vec3 index = inverse(grid.index_to_world)(world);
  std::optional<double> least;
  for (std::int32_t z = 0; z < grid.dims[2]; ++z) {
    for (std::int32_t y = 0; y < grid.dims[1]; ++y) {
      for (std::int32_t x = 0; x < grid.dims[0]; ++x) {
        if (std::abs(index[0] - x) > 0.5 || std::abs(index[1] - y) > 0.5 ||
            std::abs(index[2] - z) > 0.5) {
          continue;
        }
        const float threshold =
            grid.thresholds[static_cast<std::size_t>((z * grid.dims[1] + y) * grid.dims[0] + x)];
        if (std::isnan(threshold)) continue;
        least = std::min(least.value_or(INFINITY), static_cast<double>(threshold));
      }
    }
  }
  return least;
}

// Returns the view's threshold in world units; all numbers of the view must be in world
// coordinates.
inline double view_says(const ThresholdView& view, const Vec3& world, double unit) {
  const auto minus = [](const Vec3& a, const Vec3& b) {
    return Vec3{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  };
  const auto product = [](const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const auto turned = [](const Vec3& a, const Vec3& b) {
    return Vec3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto unit_of = [&product](const Vec3& v) {
    const double length = std::sqrt(product(v, v));
    return Vec3{v[0] / length, v[1] / length, v[2] / length};
  };
  const Vec3 to_place = minus(world, view.eye);
  const double half_height = std::tan(view.field_of_view * 3.14159265358979323846 / 360);
  const double seen = view.tolerance_pixels * 2 * std::sqrt(product(to_place, to_place)) *
                      half_height / view.height_pixels;
  if (!view.frustum) return seen;
  const Vec3 ahead = unit_of(minus(view.frustum->look_at, view.eye));
  const Vec3 right = unit_of(turned(ahead, view.frustum->up));
  const Vec3 up = turned(right, ahead);
  const double depth = product(to_place, ahead);
  const bool is_inside =
      depth >= 0 && std::abs(product(to_place, up)) <= half_height * depth &&
      std::abs(product(to_place, right)) <= half_height * view.frustum->aspect * depth;
  return is_inside ? seen : std::max(seen, view.frustum->outside * unit);
}

// Returns the threshold at a place in grid coordinates, in world units, by the definition.
inline double threshold_at(const IsosurfaceRequest& request, const DatasetInfo& info,
                           const Vec3& place) {
  const LocalThresholds& thresholds = request.thresholds;
  const double unit = request.unit == ErrorUnit::kVoxel ? voxel_length(info) : 1.0;
  const Vec3 world = grid_to_world(info)(place);
  const bool is_in_world = thresholds.coordinates == CoordinateSystem::kWorld;
  const Vec3 in_regions = is_in_world ? world : grid_to_index(info)(place);

  std::optional<double> last_region;
  std::optional<double> least;
  const auto say = [&least](double threshold) {
    least = std::min(least.value_or(INFINITY), threshold);
  };
  for (const ThresholdRegion& region : thresholds.regions) {
    if (!contains_place(region, in_regions)) continue;
    last_region = region.threshold * unit;
    say(*last_region);
  }
  std::optional<double> by_view;
  if (thresholds.view) {
    ThresholdView view = *thresholds.view;
    if (!is_in_world) {
      view.eye = info.index_to_world(view.eye);
      if (view.frustum) {
        view.frustum->look_at = info.index_to_world(view.frustum->look_at);
        const Vec3 top = info.index_to_world(view.frustum->up);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          view.frustum->up[axis] = top[axis] - info.index_to_world.translation[axis];
        }
      }
    }
    by_view = view_says(view, world, unit);
    say(*by_view);
  }
  std::optional<double> by_grid;
  if (thresholds.grid) by_grid = grid_says(*thresholds.grid, world);
  if (by_grid) say(*by_grid *= unit);

  const double everywhere = request.error * unit;
  const double here = thresholds.combination == Combination::kMinimum
                          ? least.value_or(everywhere)
                          : last_region.value_or(by_view.value_or(by_grid.value_or(everywhere)));
  return std::max(here, thresholds.error_floor * unit);
}

}  // namespace multitetra::testing
