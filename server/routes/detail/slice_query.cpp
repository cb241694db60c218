#include "server/routes/detail/slice_query.hpp"

#include <algorithm>

#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {
namespace {

// A field of a query for a slice or probe; compare RequestField.
template <typename Query>
struct QueryField {
  std::string_view name;
  std::string_view value_syntax;  // "x|y|z" or a description.
  FieldError (*set)(const QueryField& field, std::string_view text, Query& query);
  bool is_repeatable = false;
};

std::optional<std::size_t> axis_from(std::string_view text) {
  constexpr std::string_view kAxes = "xyz";
  const std::size_t axis = text.size() == 1 ? kAxes.find(text) : std::string_view::npos;
  if (axis == std::string_view::npos) return std::nullopt;
  return axis;
}

std::optional<Vec3> vector_from(std::string_view text) {
  const auto numbers = parse_numbers<double>(text, 3);
  if (!numbers) return std::nullopt;
  return Vec3{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

std::optional<std::vector<double>> extent_from(std::string_view text) {
  const auto extent = parse_number_list<double>(text, 1, 2);
  const auto is_length = [](double v) { return v > 0 && v <= kMaxCoordinate; };
  if (!extent || !std::all_of(extent->begin(), extent->end(), is_length)) return std::nullopt;
  return extent;
}

std::optional<std::uint32_t> pixels_from(std::string_view text) {
  const auto count = parse_number<std::uint32_t>(text);
  return count && *count >= 2 && *count <= kMaxSlicePixels ? count : std::nullopt;
}

std::optional<double> decimal_from(std::string_view text) { return parse_number<double>(text); }

std::optional<double> window_from(std::string_view text) {
  const auto window = parse_number<double>(text);
  return window && *window > 0 ? window : std::nullopt;
}

std::optional<SliceFormat> format_from(std::string_view text) {
  if (text == "png") return SliceFormat::kPng;
  if (text == "raw") return SliceFormat::kRaw;
  return std::nullopt;
}

FieldError add_place(const QueryField<ProbeRequest>& field, std::string_view text,
                     ProbeRequest& probe) {
  const auto place = vector_from(text);
  if (!place) return "must be " + std::string(field.value_syntax);
  probe.places.push_back(*place);
  return std::nullopt;
}

using N = NamedSlice;
using S = SliceQuery;
using P = ProbeRequest;

constexpr std::string_view kThreeNumbers = "three numbers, X,Y,Z";
constexpr std::string_view kPixels = "a number of pixels, 2 or more";

constexpr QueryField<S> kSliceFields[] = {
    {"axis", "x|y|z", set_word<&N::axis, axis_from>},
    {"at", "a number", set_word<&N::at, decimal_from>},
    {"center", kThreeNumbers, set_word<&N::center, vector_from>},
    {"normal", kThreeNumbers, set_word<&N::normal, vector_from>},
    {"up", kThreeNumbers, set_word<&N::up, vector_from>},
    {"extent", "a width, or a width and a height, WIDTH,HEIGHT, greater than 0",
     set_word<&N::extent, extent_from>},
    {"origin", kThreeNumbers, set_word<&N::origin, vector_from>},
    {"right", kThreeNumbers, set_word<&N::right, vector_from>},
    {"down", kThreeNumbers, set_word<&N::down, vector_from>},
    {"coordinates", "world|index", set_word<&N::coordinates, coordinate_system_from>},
    {"width", kPixels, set_word<&SlicePixels::width, pixels_from>},
    {"height", kPixels, set_word<&SlicePixels::height, pixels_from>},
    {"interpolation", "nearest|linear", set_word<&N::interpolation, interpolation_from>},
    {"detail", "auto|full|coarse", set_word<&N::detail, slice_detail_from>},
    {"format", "png|raw", set_word<&S::format, format_from>},
    {"window", "a number greater than 0", set_word<&S::window, window_from>},
    {"level", "a number", set_word<&S::level, decimal_from>},
    {"colors", "gray|viridis|cividis|coolwarm", set_word<&S::colors, color_map_from>},
    {"color_scale", "linear|log", set_word<&S::is_logarithmic, is_logarithmic_from>},
    {"no_value_color", "a color, RRGGBB", set_word<&S::no_value_color, rgb_from>}};

constexpr QueryField<P> kProbeFields[] = {
    {"at", kThreeNumbers, add_place, /*is_repeatable=*/true},
    {"coordinates", "world|index", set_word<&P::coordinates, coordinate_system_from>}};

// Parses a query whose table of fields sets it.
template <typename Query, typename Fields>
Result<Query> parsed(const std::vector<std::pair<std::string, std::string>>& query,
                     const Fields& fields) {
  static const Setters<Query> kSetters =
      setters_of<Query>(fields, [](Query& whole) -> Query& { return whole; });
  return parse_query<Query>(query, kSetters);
}

}  // namespace

Result<SliceQuery> parse_slice_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parsed<SliceQuery>(query, kSliceFields);
}

Result<ColorScale> scale_for(const SliceQuery& query, const DatasetInfo& info) {
  const double window = query.window.value_or(info.max - info.min);
  const double level = query.level.value_or(0.5 * (info.min + info.max));
  const ColorScale scale{.map = query.colors,
                         .low = level - 0.5 * window,
                         .high = level + 0.5 * window,
                         .is_logarithmic = query.is_logarithmic,
                         .no_value = query.no_value_color.value_or(Rgb{})};
  if (scale.is_logarithmic && !(scale.low > 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "color_scale=log requires values above 0; set window= and level=, now the smallest "
                "value is " +
                    shortest_text(scale.low) + ".");
  }
  return scale;
}

Result<ProbeRequest> parse_probe_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  auto probe = parsed<ProbeRequest>(query, kProbeFields);
  if (!probe) return probe;
  if (probe->places.empty()) {
    return fail(ErrorCode::kInvalidArgument, "Give a place with at=X,Y,Z, once or several times.");
  }
  return validated(*probe);
}

}  // namespace multitetra
