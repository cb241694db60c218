#include "server/tilesets/neuroglancer_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "server/tilesets/detail/metres.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::int32_t, 3> kChunk = {64, 64, 16};
// The coarsest scale has at least this many voxels along the longest side.
constexpr std::int32_t kMinVoxels = 64;
// Rounding errors of affine maps, in voxels.
constexpr double kRounding = 1e-6;

// The image at full resolution.
struct Frame {
  std::array<std::int32_t, 3> size{};   // In voxels.
  std::array<std::int32_t, 3> first{};  // The first voxel, counted from the world's origin.
  Vec3 resolution{};                    // The sides of a voxel, in world units.
  Affine to_index;                      // From voxels, counted from the first, to samples.
};

// Returns for each axis of the world the grid's axis that is closest to it.
std::array<std::size_t, 3> closest_axes(const DatasetInfo& info) {
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::array<std::size_t, 3> best = order;
  double best_sum = -1;
  do {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec3& step = info.index_to_world.columns[order[axis]];
      sum += std::abs(step[axis]) / length(step);
    }
    if (sum > best_sum + kRounding) {
      best_sum = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

// Maps exactly where it maps voxels to samples up to rounding errors.
Affine snapped(Affine map) {
  for (Vec3* vector : {&map.columns[0], &map.columns[1], &map.columns[2], &map.translation}) {
    for (double& value : *vector) {
      if (std::abs(value - std::round(value)) < kRounding) value = std::round(value);
    }
  }
  return map;
}

Frame frame_of(const DatasetInfo& info) {
  Frame frame;
  const std::array<std::size_t, 3> axes = closest_axes(info);
  Affine to_world;  // From voxels, counted from the first.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    frame.resolution[axis] = info.spacing[axes[axis]];
    double low = info.index_to_world.translation[axis];
    double extent = 0;
    for (std::size_t along = 0; along < 3; ++along) {
      const double end = info.index_to_world.columns[along][axis] * (info.dims[along] - 1);
      low += std::min(end, 0.0);
      extent += std::abs(end);
    }
    const double side = frame.resolution[axis];
    const auto whole = [side](double distance) {
      constexpr double kLast = std::numeric_limits<std::int32_t>::max() / 2;
      return static_cast<std::int32_t>(
          std::clamp(std::floor(distance / side + kRounding), -kLast, kLast));
    };
    frame.first[axis] = whole(low);
    frame.size[axis] = whole(extent) + 1;
    to_world.columns[axis][axis] = side;
    to_world.translation[axis] = low;
  }
  frame.to_index = snapped(composed(inverse(info.index_to_world), to_world));
  return frame;
}

std::int32_t voxels(const Frame& frame, std::size_t axis, std::int32_t step) {
  return (frame.size[axis] + step - 1) / step;
}

// Returns the first voxel of a scale. Its sample lies within half a voxel of its middle.
std::int32_t first_voxel(const Frame& frame, std::size_t axis, std::int32_t step) {
  return static_cast<std::int32_t>(std::floor((frame.first[axis] + 0.5) / step));
}

bool has_scale(const Frame& frame, std::int32_t step) {
  return step == 1 || *std::max_element(frame.size.begin(), frame.size.end()) / step >= kMinVoxels;
}

std::string scale_name(std::int32_t step) {
  const std::string number = std::to_string(step);
  return number + "_" + number + "_" + number;
}

Affine scaling(const Vec3& factors, double shift = 0) {
  Affine map;
  for (std::size_t axis = 0; axis < 3; ++axis) map.columns[axis][axis] = factors[axis];
  map.translation = scaled(factors, shift);
  return map;
}

}  // namespace

std::string image_info_json(const DatasetInfo& info) {
  static constexpr std::array<const char*, 5> kTypes = {"uint8", "int8", "uint16", "int16",
                                                        "float32"};
  const Frame frame = frame_of(info);
  const double nanometres = 1e9 * metres_a_unit(info);
  Json scales = Json::array();
  for (std::int32_t step = 1; has_scale(frame, step); step *= 2) {
    Json size = Json::array();
    Json resolution = Json::array();
    Json first = Json::array();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      size.push_back(voxels(frame, axis, step));
      resolution.push_back(frame.resolution[axis] * nanometres * step);
      first.push_back(first_voxel(frame, axis, step));
    }
    scales.push_back({{"key", scale_name(step)},
                      {"size", std::move(size)},
                      {"resolution", std::move(resolution)},
                      {"voxel_offset", std::move(first)},
                      {"chunk_sizes", {kChunk}},
                      {"encoding", "raw"}});
  }
  const Json volume = {{"@type", "neuroglancer_multiscale_volume"},
                       {"type", "image"},
                       {"data_type", kTypes[static_cast<std::size_t>(info.type)]},
                       {"num_channels", 1},
                       {"scales", std::move(scales)}};
  return json_text(volume) + "\n";
}

std::optional<ImageChunk> image_chunk_from(const DatasetInfo& info, std::string_view scale,
                                           std::string_view chunk) {
  const Frame frame = frame_of(info);
  std::int32_t step = 1;
  while (has_scale(frame, step) && scale_name(step) != scale) step *= 2;
  if (!has_scale(frame, step)) return std::nullopt;
  const auto number = [&](std::string_view before) -> std::optional<std::int32_t> {
    if (!chunk.starts_with(before)) return std::nullopt;
    chunk.remove_prefix(before.size());
    return take_number<std::int32_t>(chunk);
  };
  ImageChunk found;
  Affine to_frame = scaling({1.0 * step, 1.0 * step, 1.0 * step});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto first = number(axis == 0 ? "" : "_");
    const auto last = first ? number("-") : std::nullopt;
    if (!last) return std::nullopt;
    const std::int64_t offset = first_voxel(frame, axis, step);
    const std::int64_t begin = *first - offset;
    const std::int64_t all = voxels(frame, axis, step);
    if (begin < 0 || begin >= all || begin % kChunk[axis] != 0 ||
        *last - offset != std::min(all, begin + kChunk[axis])) {
      return std::nullopt;
    }
    found.size[axis] = *last - *first;
    to_frame.translation[axis] = static_cast<double>(step) * static_cast<double>(begin);
  }
  if (!chunk.empty()) return std::nullopt;
  found.to_index = composed(frame.to_index, to_frame);
  return found;
}

Affine manifest_to_image(const DatasetInfo& info) {
  const Frame frame = frame_of(info);
  const double nanometres = 1e9 * metres_a_unit(info);
  // Samples are in the middle of their voxels on both sides.
  Affine to_index = inverse(scaling(scaled(info.spacing, nanometres), 0.5));
  Affine to_voxel = inverse(frame.to_index);
  for (std::size_t axis = 0; axis < 3; ++axis) to_voxel.translation[axis] += frame.first[axis];
  return composed(scaling(scaled(frame.resolution, nanometres), 0.5), composed(to_voxel, to_index));
}

}  // namespace multitetra
