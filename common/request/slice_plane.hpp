// Slices specified by users: by an axis and a sample, or by a place and a direction.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/slice_request.hpp"

namespace multitetra {

// The size of a slice in pixels. If both are absent, the finest samples or kDefaultSlicePixels per
// side determine it, whichever gives fewer pixels; if one is absent, it follows from square pixels.
struct SlicePixels {
  std::optional<std::uint32_t> width = {};  // At least 2.
  std::optional<std::uint32_t> height = {};
};
inline constexpr std::uint32_t kDefaultSlicePixels = 1024;

// Returns the layer of samples at index `at` along an axis (0 to 2); fractional indices lie between
// layers. The picture's sides are the data's other two axes, with x or y to the right; y points
// down in layers along z, and z points up in the others. The first and last pixels are the first
// and last samples, and pixels are square in the world.
[[nodiscard]] SliceRequest axis_slice(const DatasetInfo& info, std::size_t axis, double at,
                                      const SlicePixels& pixels);

// A plane through `center` whose `normal` points to the viewer, with lengths in `coordinates`.
struct ObliquePlane {
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  Vec3 center = {0, 0, 0};
  Vec3 normal = {0, 0, 1};      // Not 0; of any length.
  std::optional<Vec3> up = {};  // In the picture; absent: the third axis, or the second.
  // The size of the visible part, > 0; absent: all data.
  std::optional<double> width = {};
  std::optional<double> height = {};
};
// Fails with kInvalidArgument if the normal is zero or parallel to `up`.
[[nodiscard]] Result<SliceRequest> oblique_slice(const DatasetInfo& info, const ObliquePlane& plane,
                                                 const SlicePixels& pixels);

// A slice as typed by users. The plane is specified in one of three ways; the default is the middle
// layer along the third axis.
struct NamedSlice {
  // The axis of the plane, 0 to 2.
  std::optional<std::size_t> axis = {};
  // The position along the axis, in samples.
  std::optional<double> at = {};
  std::optional<Vec3> normal = {}, center = {}, up = {};
  std::optional<std::vector<double>> extent = {};  // Width, or width and height, > 0.
  std::optional<Vec3> origin = {}, right = {}, down = {};
  // The coordinate system of all members but `at`.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  SlicePixels pixels = {};
  Interpolation interpolation = Interpolation::kLinear;
  SliceDetail detail = SliceDetail::kAuto;
};
// Returns the validated slice of a dataset. Fails with kInvalidArgument if the fields contradict
// each other or the place is outside the data.
[[nodiscard]] Result<SliceRequest> slice_for(const NamedSlice& named, const DatasetInfo& info);

}  // namespace multitetra
