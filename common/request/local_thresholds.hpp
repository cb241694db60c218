// The parts of a threshold map in a request: regions, a coarse grid of thresholds, a view.
//
// Each of them has a threshold at some places and none at the others. The threshold at a place is:
//
//   kInOrder   that of the last region that contains it; else the view's; else the grid's; else the
//              request's error
//   kMinimum   the least of all regions, view and grid that have one there; else the request's
//              error
//
// and nowhere less than `at_least`. Thresholds are in the request's unit.
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
// Coordinates, radii and normals are within plus and minus this: their squares stay finite.
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

// Regions are closed: their border belongs to them.
struct BoxShape {
  Vec3 low = {};   // At most `high` on every axis.
  Vec3 high = {};  // A box without extent is a place, a line or a face.

  friend bool operator==(const BoxShape&, const BoxShape&) = default;
};
struct BallShape {
  Vec3 centre = {};
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

// Thresholds at the samples of an image, each valid in the sample's voxel: half a step around it on
// all sides, borders included. Never interpolated: where voxels meet the least of them holds.
struct ThresholdGrid {
  std::array<std::int32_t, 3> dims = {};  // Each at least 1; at most kMaxGridThresholds together.
  Affine index_to_world = {};             // Its own, and invertible.
  // x fastest; finite and >= 0, or NaN: no threshold.
  std::vector<float> thresholds = {};

  // Equal where both are absent.
  friend bool operator==(const ThresholdGrid& a, const ThresholdGrid& b);
};

// The view frustum, as a pyramid with its apex in the eye.
struct Frustum {
  Vec3 look_at = {};    // A place in the middle of the picture; not the eye.
  Vec3 up = {0, 0, 1};  // Upwards in the picture; not along the viewing direction.
  double aspect = 1;    // Width of the viewport by its height, > 0.
  double outside = 0;   // Outside the frustum no threshold is less; finite, >= 0.

  friend bool operator==(const Frustum&, const Frustum&) = default;
};

// A threshold with constant screen-space error: at distance d from the eye, the length in world
// units that `tolerance_pixels` pixels cover. It is defined everywhere.
struct ThresholdView {
  Vec3 eye = {};
  double field_of_view = 0;     // Vertical, degrees, between 0 and 180.
  double height_pixels = 0;     // The height of the viewport, > 0.
  double tolerance_pixels = 0;  // >= 0
  std::optional<Frustum> frustum = {};

  friend bool operator==(const ThresholdView&, const ThresholdView&) = default;
};

struct LocalThresholds {
  // For regions and view.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  Combination combination = Combination::kInOrder;
  std::vector<ThresholdRegion> regions = {};       // At most kMaxThresholdRegions; the last wins.
  std::shared_ptr<const ThresholdGrid> grid = {};  // Shared, for requests are copied often.
  std::optional<ThresholdView> view = {};
  double at_least = 0;  // Finite, >= 0.

  // Whether the request's error and `at_least` are all there is.
  [[nodiscard]] bool is_uniform() const { return regions.empty() && !grid && !view; }

  // Grids are equal when their contents are.
  friend bool operator==(const LocalThresholds& a, const LocalThresholds& b);
};

// The first field that is out of its documented range, with the index of its region; nullopt when
// nothing is. kLimitExceeded for too many regions or thresholds of a grid, else kInvalidArgument.
[[nodiscard]] Result<void> check_thresholds(const LocalThresholds& thresholds);

}  // namespace multitetra
