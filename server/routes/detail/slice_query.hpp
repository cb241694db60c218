// A query as a slice, or as places to be probed. Pure.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/image/color_map.hpp"
#include "common/request/probe_request.hpp"
#include "common/request/slice_plane.hpp"

namespace multitetra {

enum class SliceFormat {
  kPng,  // Colors, for people.
  kRaw,  // Floats, for programs.
};

struct SliceQuery {
  NamedSlice slice = {};
  SliceFormat format = SliceFormat::kPng;
  std::optional<double> window = {}, level = {};  // Width and center of the range of shown values.
  ColorMap colors = ColorMap::kGray;
  bool is_logarithmic = false;
  std::optional<Rgb> no_value_color = {};  // Absent: transparent.
};

// axis, at, centre, normal, up, extent, origin, right, down, coordinates, width, height,
// interpolation, detail, format, window, level, colors, color_scale, no_value_color.
// kInvalidArgument, naming the parameter, when one is unknown, repeated or invalid.
[[nodiscard]] Result<SliceQuery> parse_slice_query(
    const std::vector<std::pair<std::string, std::string>>& query);

// The slice of a dataset, checked as one that came over the wire. Without any plane it is the
// middle layer along the third axis.
[[nodiscard]] Result<SliceRequest> slice_for(const SliceQuery& query, const DatasetInfo& info);

// The range of values of the colors: the window, or all that there are. kInvalidArgument where a
// logarithmic scale would begin at or below 0.
[[nodiscard]] Result<ColorScale> scale_for(const SliceQuery& query, const DatasetInfo& info);

// at=X,Y,Z once for each place, coordinates.
[[nodiscard]] Result<ProbeRequest> parse_probe_query(
    const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace multitetra
