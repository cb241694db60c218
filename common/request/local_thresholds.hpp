// The parts of a threshold map in a request: regions, a coarse grid of thresholds, a view.
//
// Each of them defines thresholds at some places only. The threshold at a place is
//
//   kInOrder   the threshold of the last region that contains it; else of the view; else of the
//              grid; else the request's error
//   kMinimum   the least of all regions, view and grid that define one; else the request's error
//
// and never less than `error_floor`. Thresholds are in the request's unit.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxThresholdRegions = 10000;
inline constexpr std::size_t kMaxGridThresholds = 131072;
// The limit of coordinates, radii and normals: their squares stay finite.
inline constexpr double kMaxCoordinate = 1e100;

// The coordinate systems of regions and view.
enum class CoordinateSystem {
  kWorld,  // The dataset's world coordinates.
  kIndex,  // Sample indices: the first sample is at 0, 0, 0.
};

enum class Combination { kInOrder, kMinimum };

[[nodiscard]] std::string_view name(CoordinateSystem coordinates);  // "world", "index"
[[nodiscard]] std::string_view name(Combination combination);       // "order", "minimum"
[[nodiscard]] std::optional<CoordinateSystem> coordinate_system_from(std::string_view name);
[[nodiscard]] std::optional<Combination> combination_from(std::string_view name);

// Regions include their borders.
struct BoxShape {
  Vec3 low = {};  // At most `high` on every axis.
  // A box may be flat: a place, a line or a rectangle.
  Vec3 high = {};

  friend bool operator==(const BoxShape&, const BoxShape&) = default;
};
struct BallShape {
  Vec3 center = {};
  double radius = 0;  // >= 0

  friend bool operator==(const BallShape&, const BallShape&) = default;
};
// The places x with normal . x >= offset.
struct HalfSpaceShape {
  Vec3 normal = {};  // Not 0; of any length.
  double offset = 0;

  friend bool operator==(const HalfSpaceShape&, const HalfSpaceShape&) = default;
};

struct ThresholdRegion {
  std::variant<BoxShape, BallShape, HalfSpaceShape> shape = {};
  double threshold = 0;  // Finite, >= 0.

  friend bool operator==(const ThresholdRegion&, const ThresholdRegion&) = default;
};

// Thresholds at the samples of an image. Each applies to its sample's voxel, half a step around it
// on all sides, borders included, without interpolation; where voxels meet, the least applies.
struct ThresholdGrid {
  // Each at least 1; their product is at most kMaxGridThresholds.
  std::array<std::int32_t, 3> dims = {};
  Affine index_to_world = {};  // From the grid's own indices; invertible.
  // x fastest; finite and >= 0, or NaN for no threshold.
  std::vector<float> thresholds = {};

  // NaN equals NaN.
  friend bool operator==(const ThresholdGrid& a, const ThresholdGrid& b);
};

// The view frustum: a pyramid with its apex at the eye.
struct Frustum {
  Vec3 look_at = {};    // A place in the middle of the picture, other than the eye.
  Vec3 up = {0, 0, 1};  // The picture's upward direction, not parallel to the view.
  double aspect = 1;    // Width / height of the viewport, > 0.
  double outside = 0;   // The least threshold outside the frustum; finite, >= 0.

  friend bool operator==(const Frustum&, const Frustum&) = default;
};

// A constant screen-space error: at distance d from the eye, the threshold is the length in world
// units that covers `tolerance_pixels` pixels. Defines a threshold everywhere.
struct ThresholdView {
  Vec3 eye = {};
  double field_of_view = 0;     // Vertical, degrees, between 0 and 180.
  double height_pixels = 0;     // The height of the viewport, > 0.
  double tolerance_pixels = 0;  // >= 0
  std::optional<Frustum> frustum = {};

  friend bool operator==(const ThresholdView&, const ThresholdView&) = default;
};

struct LocalThresholds {
  // The coordinate system of `regions` and `view`.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  Combination combination = Combination::kInOrder;
  // At most kMaxThresholdRegions; see the top of this file for their order.
  std::vector<ThresholdRegion> regions = {};
  // Shared, since requests are copied often.
  std::shared_ptr<const ThresholdGrid> grid = {};
  std::optional<ThresholdView> view = {};
  double error_floor = 0;  // Finite, >= 0.

  // Returns whether only the request's error and `error_floor` apply.
  [[nodiscard]] bool is_uniform() const { return regions.empty() && !grid && !view; }

  // Compares grids by content.
  friend bool operator==(const LocalThresholds& a, const LocalThresholds& b);
};

// Fails for the first field out of its documented range, naming it with the index of its region.
// kLimitExceeded for too many regions or grid thresholds, otherwise kInvalidArgument.
[[nodiscard]] Result<void> check_thresholds(const LocalThresholds& thresholds);

}  // namespace multitetra
