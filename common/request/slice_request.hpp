// A request for the field on a plane through a dataset, pixel by pixel.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// The most pixels of one slice; 4 bytes each.
inline constexpr std::uint32_t kMaxSlicePixels = std::uint32_t{1} << 21;

enum class Interpolation {
  kNearest,  // The sample that is nearest, exactly as it is stored.
  kLinear,   // Trilinear between the eight samples around a place.
};

// The samples that a slice is made of.
enum class SliceDetail {
  kAuto,    // All of them, or every eighth where that is as good or all would cost too much.
  kFull,    // All of them.
  kCoarse,  // Every eighth along each axis, where there are some.
};

[[nodiscard]] std::string_view name(SliceDetail detail);  // "auto", "full", "coarse"
[[nodiscard]] std::optional<Interpolation> interpolation_from(std::string_view name);
[[nodiscard]] std::optional<SliceDetail> slice_detail_from(std::string_view name);

// Pixel (i, j), from the left and from above, is the field at origin + i right + j down.
struct SliceRequest {
  // The coordinates of the three vectors.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  Vec3 origin = {0, 0, 0};  // Coordinates from -kMaxCoordinate to kMaxCoordinate, as of the others.
  Vec3 right = {1, 0, 0};
  Vec3 down = {0, 1, 0};
  // Pixels, at least 1; width times height is at most kMaxSlicePixels.
  std::uint32_t width = 1;
  std::uint32_t height = 1;
  Interpolation interpolation = Interpolation::kLinear;
  SliceDetail detail = SliceDetail::kAuto;

  [[nodiscard]] std::size_t pixels() const { return std::size_t{width} * height; }
  friend bool operator==(const SliceRequest&, const SliceRequest&) = default;
};

// kInvalidArgument or kLimitExceeded, naming the field and its range, unless every field is within
// it.
[[nodiscard]] Result<SliceRequest> validated(const SliceRequest& slice);

// The same slice in sample indices. Requires a dataset whose map to the world can be inverted.
[[nodiscard]] SliceRequest in_indices(const SliceRequest& slice, const DatasetInfo& info);

}  // namespace multitetra
