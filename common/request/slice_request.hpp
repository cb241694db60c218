// A request for the field on a plane through a dataset, or on layers of planes, pixel by pixel.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// The maximum number of pixels of a slice; 4 bytes each.
inline constexpr std::uint32_t kMaxSlicePixels = std::uint32_t{1} << 21;

enum class Interpolation {
  kNearest,  // The nearest sample, exactly as stored.
  kLinear,   // Trilinear between the eight surrounding samples.
};

// The samples used for a slice.
enum class SliceDetail {
  kAuto,    // All, or every eighth along each axis if that suffices or all would cost too much.
  kFull,    // All samples.
  kCoarse,  // Every eighth along each axis, if the dataset has them.
};

[[nodiscard]] std::string_view name(SliceDetail detail);  // "auto", "full", "coarse"
[[nodiscard]] std::optional<Interpolation> interpolation_from(std::string_view name);
[[nodiscard]] std::optional<SliceDetail> slice_detail_from(std::string_view name);

// Pixel (i, j) of layer k, counted from the left and from the top, is the field at
// origin + i right + j down + k inward.
struct SliceRequest {
  // The coordinates of the vectors.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  // All coordinates are from -kMaxCoordinate to kMaxCoordinate.
  Vec3 origin = {0, 0, 0};
  Vec3 right = {1, 0, 0};
  Vec3 down = {0, 1, 0};
  Vec3 inward = {0, 0, 1};
  // In pixels, at least 1; width * height * layers is at most kMaxSlicePixels.
  std::uint32_t width = 1;
  std::uint32_t height = 1;
  std::uint32_t layers = 1;
  Interpolation interpolation = Interpolation::kLinear;
  SliceDetail detail = SliceDetail::kAuto;
  bool accepts_packed = false;  // The reply may be packed (see packed_values.hpp).

  [[nodiscard]] std::size_t pixels_of_layer() const { return std::size_t{width} * height; }
  [[nodiscard]] std::size_t pixels() const { return layers * pixels_of_layer(); }
  friend bool operator==(const SliceRequest&, const SliceRequest&) = default;
};

// Returns the request, or kInvalidArgument or kLimitExceeded, naming the field and its range.
[[nodiscard]] Result<SliceRequest> validated(const SliceRequest& slice);

// Converts the slice to sample indices. Requires an invertible index_to_world.
[[nodiscard]] SliceRequest in_indices(const SliceRequest& slice, const DatasetInfo& info);

}  // namespace multitetra
