#include "common/request/slice_plane.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace multitetra {
namespace {

// A rectangle of the plane in the slice's coordinates, between the centers of its outermost pixels.
struct Rectangle {
  Vec3 first;  // The top left corner.
  // From left to right, of length 1.
  Vec3 right;
  // From top to bottom, of length 1.
  Vec3 down;
  double width = 0;
  double height = 0;
  double width_in_world = 0;  // The same lengths in the world, where pixels are square.
  double height_in_world = 0;
};

// Returns at least one pixel.
std::uint32_t pixels_along(double length, double pixel_spacing) {
  constexpr double kMaxSteps = 1e6;  // More than any slice may have: rejected by validation.
  // Tolerates rounding in an integral number of steps.
  const double steps = length / pixel_spacing + 1e-6;
  // NaN is rejected by validation, too.
  return steps >= 0 ? 1 + static_cast<std::uint32_t>(std::min(steps, kMaxSteps)) : 1;
}

double pixel_spacing_for(const Rectangle& shown, double finest, const SlicePixels& pixels) {
  const auto for_side = [](double length, std::uint32_t count) {
    return length / std::max<std::uint32_t>(count - 1, 1);
  };
  double pixel_spacing = 0;
  if (pixels.width) pixel_spacing = for_side(shown.width_in_world, *pixels.width);
  if (pixels.height)
    pixel_spacing = std::max(pixel_spacing, for_side(shown.height_in_world, *pixels.height));
  if (!pixels.width && !pixels.height) {
    pixel_spacing = std::max({finest, for_side(shown.width_in_world, kDefaultSlicePixels),
                              for_side(shown.height_in_world, kDefaultSlicePixels)});
  }
  return pixel_spacing > 0 ? pixel_spacing : finest;
}

SliceRequest slice_of(const Rectangle& shown, CoordinateSystem coordinates, double finest,
                      const SlicePixels& pixels) {
  const double pixel_spacing = pixel_spacing_for(shown, finest, pixels);
  SliceRequest slice{.coordinates = coordinates, .origin = shown.first};
  slice.width = pixels_along(shown.width_in_world, pixel_spacing);
  slice.height = pixels_along(shown.height_in_world, pixel_spacing);
  const auto step = [pixel_spacing](const Vec3& direction, double length, double in_world) {
    return scaled(direction, in_world > 0 ? pixel_spacing * length / in_world : pixel_spacing);
  };
  slice.right = step(shown.right, shown.width, shown.width_in_world);
  slice.down = step(shown.down, shown.height, shown.height_in_world);
  return slice;
}

Vec3 unit(std::size_t axis, double length) {
  Vec3 v = {0, 0, 0};
  v[axis] = length;
  return v;
}

// Returns how far the data extends from the center along a direction, to either side.
double reach(const DatasetInfo& info, const ObliquePlane& plane, const Vec3& direction) {
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 place{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = (corner >> axis & 1) != 0 ? info.dims[axis] - 1 : 0;
    }
    if (plane.coordinates == CoordinateSystem::kWorld) place = info.index_to_world(place);
    farthest = std::max(farthest, std::abs(dot(difference(place, plane.center), direction)));
  }
  return farthest;
}

std::optional<Vec3> direction_of(const Vec3& v) {
  const double size = length(v);
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  return scaled(v, 1 / size);
}

tl::unexpected<Error> mixed(const char* text) { return fail(ErrorCode::kInvalidArgument, text); }

}  // namespace

SliceRequest axis_slice(const DatasetInfo& info, std::size_t axis, double at,
                        const SlicePixels& pixels) {
  const std::size_t across = axis == 0 ? 1 : 0;
  const std::size_t along = axis == 2 ? 1 : 2;
  const bool is_upwards = along == 2;
  Rectangle shown{.first = unit(axis, at),
                  .right = unit(across, 1),
                  .down = unit(along, is_upwards ? -1 : 1),
                  .width = static_cast<double>(info.dims[across] - 1),
                  .height = static_cast<double>(info.dims[along] - 1)};
  if (is_upwards) shown.first[along] = shown.height;
  shown.width_in_world = shown.width * info.spacing[across];
  shown.height_in_world = shown.height * info.spacing[along];
  const double finest = std::min(info.spacing[across], info.spacing[along]);
  return slice_of(shown, CoordinateSystem::kIndex, finest, pixels);
}

Result<SliceRequest> oblique_slice(const DatasetInfo& info, const ObliquePlane& plane,
                                   const SlicePixels& pixels) {
  const auto normal = direction_of(plane.normal);
  if (!normal) {
    return fail(ErrorCode::kInvalidArgument,
                "The normal of a slice has no direction; it must not be 0,0,0.");
  }
  constexpr double kNearlyAlong = 0.999;
  const Vec3 default_up = std::abs((*normal)[2]) < kNearlyAlong ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  const auto right = direction_of(cross(plane.up.value_or(default_up), *normal));
  if (!right) {
    return fail(ErrorCode::kInvalidArgument,
                "The up vector of a slice must not be 0,0,0 or parallel to its normal.");
  }
  const Vec3 down = cross(*right, *normal);
  const double width = plane.width.value_or(2 * reach(info, plane, *right));
  const double height = plane.height.value_or(2 * reach(info, plane, down));
  const Vec3 left_end = moved(plane.center, -width / 2, *right);
  const bool is_world = plane.coordinates == CoordinateSystem::kWorld;
  return slice_of({.first = moved(left_end, -height / 2, down),
                   .right = *right,
                   .down = down,
                   .width = width,
                   .height = height,
                   .width_in_world = width,
                   .height_in_world = height},
                  plane.coordinates, is_world ? voxel_length(info) : 1, pixels);
}

namespace {

Result<SliceRequest> plane_for(const NamedSlice& named, const DatasetInfo& info) {
  const bool has_vectors = named.origin || named.right || named.down;
  const bool is_oblique = named.center || named.normal || named.up || named.extent;
  const bool is_of_axis = named.axis || named.at;
  if (has_vectors + is_oblique + is_of_axis > 1) {
    return mixed(
        "Specify a slice by axis and at, by normal, center, up and extent, or by origin, right and "
        "down, not by several of these.");
  }
  if (has_vectors) {
    if (!named.origin || !named.right || !named.down || !named.pixels.width ||
        !named.pixels.height) {
      return mixed("A slice with origin, right or down needs all three, and width and height.");
    }
    return SliceRequest{.coordinates = named.coordinates,
                        .origin = *named.origin,
                        .right = *named.right,
                        .down = *named.down,
                        .width = *named.pixels.width,
                        .height = *named.pixels.height};
  }
  if (is_oblique) {
    if (!named.normal) return mixed("A slice with center, up or extent needs a normal.");
    const Vec3 middle = {0.5 * (info.dims[0] - 1), 0.5 * (info.dims[1] - 1),
                         0.5 * (info.dims[2] - 1)};
    const bool is_world = named.coordinates == CoordinateSystem::kWorld;
    ObliquePlane plane{
        .coordinates = named.coordinates,
        .center = named.center.value_or(is_world ? info.index_to_world(middle) : middle),
        .normal = *named.normal,
        .up = named.up};
    if (named.extent) {
      plane.width = named.extent->front();
      plane.height = named.extent->back();
    }
    return oblique_slice(info, plane, named.pixels);
  }
  const std::size_t axis = named.axis.value_or(2);
  const double last = info.dims[axis] - 1;
  const double at = named.at.value_or(std::floor(last / 2));
  if (!(at >= 0 && at <= last)) {
    return fail(ErrorCode::kInvalidArgument,
                "The layer of a slice must be within the samples, at=0 to " +
                    std::to_string(info.dims[axis] - 1) + ".");
  }
  return axis_slice(info, axis, at, named.pixels);
}

}  // namespace

Result<SliceRequest> slice_for(const NamedSlice& named, const DatasetInfo& info) {
  auto slice = plane_for(named, info);
  if (!slice) return slice;
  slice->interpolation = named.interpolation;
  slice->detail = named.detail;
  return validated(*slice);
}

}  // namespace multitetra
