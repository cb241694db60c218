// Parses queries for slices and probes. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/image/color_map.hpp"
#include "common/request/probe_request.hpp"
#include "common/request/slice_plane.hpp"
#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {

enum class SliceFormat {
  kPng,  // Colors, for people.
  kRaw,  // Floats, for programs.
};

struct SliceQuery {
  NamedSlice slice = {};
  SliceFormat format = SliceFormat::kPng;
  std::optional<double> window = {}, level = {};  // Width and center of the displayed range.
  ColorMap colors = ColorMap::kGray;
  bool is_logarithmic = false;
  std::optional<Rgb> no_value_color = {};  // None: transparent.
};

[[nodiscard]] std::span<const QueryField<SliceQuery>> slice_fields();
[[nodiscard]] std::span<const QueryField<ProbeRequest>> probe_fields();

// Returns kInvalidArgument, naming the parameter, if one is unknown, repeated or invalid.
[[nodiscard]] Result<SliceQuery> parse_slice_query(
    const std::vector<std::pair<std::string, std::string>>& query);

// Returns the slice of a dataset after the same checks as for one received by wire. Without a
// plane, it is the middle layer along the third axis.
[[nodiscard]] Result<SliceRequest> slice_for(const SliceQuery& query, const DatasetInfo& info);

// Returns the range of the color map: the window, or all values. Returns kInvalidArgument if a
// logarithmic scale would begin at or below 0.
[[nodiscard]] Result<ColorScale> scale_for(const SliceQuery& query, const DatasetInfo& info);

// Fails without a place.
[[nodiscard]] Result<ProbeRequest> parse_probe_query(
    const std::vector<std::pair<std::string, std::string>>& query);

}  // namespace multitetra
