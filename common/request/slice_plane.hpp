// Planes as people name them, an axis and a sample, or a place and a direction, as slices.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/slice_request.hpp"

namespace multitetra {

// The size of a slice in pixels. None for either: as fine as the finest samples, as far as
// kUsualSlicePixels on a side suffice for that; for one of them: what square pixels make of the
// other.
struct SlicePixels {
  std::optional<std::uint32_t> width = {};  // At least 2.
  std::optional<std::uint32_t> height = {};
};
inline constexpr std::uint32_t kUsualSlicePixels = 1024;

// The layer of samples with index `at` along an axis (0 to 2); between two samples it is between
// their layers. The sides of the picture are the other two axes of the data, x or y to the right; y
// goes down in layers along z, and z goes up in the others. Its first and last pixels are the first
// and last samples, and pixels are square in the world.
[[nodiscard]] SliceRequest axis_slice(const DatasetInfo& info, std::size_t axis, double at,
                                      const SlicePixels& pixels);

// A plane through `centre` whose `normal` points to the viewer. Directions and lengths are those of
// `coordinates`.
struct ObliquePlane {
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  Vec3 centre = {0, 0, 0};
  Vec3 normal = {0, 0, 1};      // Not 0; of any length.
  std::optional<Vec3> up = {};  // In the picture; none: the third axis, or the second.
  // The width of the visible part, > 0; absent: all of the data.
  std::optional<double> width = {};
  std::optional<double> height = {};
};
// kInvalidArgument where the normal has no direction, or up is along it.
[[nodiscard]] Result<SliceRequest> oblique_slice(const DatasetInfo& info, const ObliquePlane& plane,
                                                 const SlicePixels& pixels);

// A slice as it is typed: its plane is named in one of three ways, or is the middle layer along the
// third axis.
struct NamedSlice {
  // The axis of the plane, 0 to 2.
  std::optional<std::size_t> axis = {};
  // The position along the axis, in samples.
  std::optional<double> at = {};
  std::optional<Vec3> normal = {}, centre = {}, up = {};
  std::optional<std::vector<double>> extent = {};  // Width, or width and height, > 0.
  std::optional<Vec3> origin = {}, right = {}, down = {};
  CoordinateSystem coordinates = CoordinateSystem::kWorld;  // For all but `at`.
  SlicePixels pixels = {};
  Interpolation interpolation = Interpolation::kLinear;
  SliceDetail detail = SliceDetail::kAuto;
};
// The slice of a dataset, checked as one that came over the wire. kInvalidArgument where names do
// not go together or are of no place in the data.
[[nodiscard]] Result<SliceRequest> slice_for(const NamedSlice& named, const DatasetInfo& info);

}  // namespace multitetra
