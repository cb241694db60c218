#include "common/request/slice_request.hpp"

#include <cmath>
#include <string>

#include "common/base/enum_names.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<Interpolation, 2> kInterpolations = {{"nearest", "linear"}};
constexpr EnumNames<SliceDetail, 3> kDetails = {{"auto", "full", "coarse"}};

bool is_place(const Vec3& vector) {
  for (const double coordinate : vector) {
    if (!(std::abs(coordinate) <= kMaxCoordinate)) return false;
  }
  return true;
}

}  // namespace

std::string_view name(SliceDetail detail) { return kDetails.of(detail); }

std::optional<Interpolation> interpolation_from(std::string_view name) {
  return kInterpolations.find(name);
}

std::optional<SliceDetail> slice_detail_from(std::string_view name) { return kDetails.find(name); }

Result<SliceRequest> validated(const SliceRequest& slice) {
  for (const auto& [field, vector] : {std::pair("origin", slice.origin),
                                      {"right", slice.right},
                                      {"down", slice.down},
                                      {"inward", slice.inward}}) {
    if (is_place(vector)) continue;
    return fail(ErrorCode::kInvalidArgument,
                std::string("Slice.") + field +
                    " has a coordinate that is not a number from -1e100 to 1e100.");
  }
  if (slice.width < 1 || slice.height < 1) {
    return fail(ErrorCode::kInvalidArgument,
                "Slice.width and Slice.height are " + std::to_string(slice.width) + " and " +
                    std::to_string(slice.height) + "; they must be 1 or greater.");
  }
  if (slice.layers < 1) {
    return fail(ErrorCode::kInvalidArgument, "Slice.layers must be 1 or greater.");
  }
  // The product of all three could overflow.
  if (slice.pixels_of_layer() > kMaxSlicePixels || slice.pixels() > kMaxSlicePixels) {
    const std::string layers =
        slice.layers > 1 ? " x " + std::to_string(slice.layers) : std::string();
    return fail(ErrorCode::kLimitExceeded, "The slice has " + std::to_string(slice.width) + " x " +
                                               std::to_string(slice.height) + layers +
                                               " pixels; at most " +
                                               std::to_string(kMaxSlicePixels) + " are allowed.");
  }
  return slice;
}

SliceRequest in_indices(const SliceRequest& slice, const DatasetInfo& info) {
  if (slice.coordinates == CoordinateSystem::kIndex) return slice;
  const Affine to_index = inverse(info.index_to_world);
  const auto step = [&](const Vec3& v) { return difference(to_index(v), to_index.translation); };
  SliceRequest inside = slice;
  inside.coordinates = CoordinateSystem::kIndex;
  inside.origin = to_index(slice.origin);
  inside.right = step(slice.right);
  inside.down = step(slice.down);
  inside.inward = step(slice.inward);
  return inside;
}

}  // namespace multitetra
