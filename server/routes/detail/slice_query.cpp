#include "server/routes/detail/slice_query.hpp"

#include <algorithm>

#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"

namespace multitetra {
namespace {

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
    {"axis", "x|y|z", "z", "The layer of samples across this axis of the data",
     set_word<&N::axis, axis_from>},
    {"at", "a number", "", "Index of the layer; default: the middle layer",
     set_word<&N::at, decimal_from>},
    {"center", kThreeNumbers, "",
     "X,Y,Z: center of the oblique plane; default: the center of the data",
     set_word<&N::center, vector_from>},
    {"normal", kThreeNumbers, "", "X,Y,Z: normal of an oblique plane, towards the viewer",
     set_word<&N::normal, vector_from>},
    {"up", kThreeNumbers, "", "X,Y,Z: up vector of the picture; default: the third axis",
     set_word<&N::up, vector_from>},
    {"extent", "a width, or a width and a height, WIDTH,HEIGHT, greater than 0", "",
     "WIDTH or WIDTH,HEIGHT of the shown part of the oblique plane; default: all of the data",
     set_word<&N::extent, extent_from>},
    {"origin", kThreeNumbers, "",
     "X,Y,Z: a plane by three vectors: the center of the first pixel, top left",
     set_word<&N::origin, vector_from>},
    {"right", kThreeNumbers, "", "X,Y,Z: from a pixel to the next pixel of its row",
     set_word<&N::right, vector_from>},
    {"down", kThreeNumbers, "", "X,Y,Z: from a row to the next row",
     set_word<&N::down, vector_from>},
    {"coordinates", "world|index", "world", "Coordinates of all these parameters except at",
     set_word<&N::coordinates, coordinate_system_from>},
    {"width", kPixels, "",
     "Width in pixels, at most: a plane by axis or normal has square pixels; at most 2097152 in "
     "all. Default of width and height: the resolution of the samples, up to 1024 a side",
     set_word<&SlicePixels::width, pixels_from>},
    {"height", kPixels, "", "Height in pixels, likewise",
     set_word<&SlicePixels::height, pixels_from>},
    {"interpolation", "nearest|linear", "linear", "nearest: the stored samples",
     set_word<&N::interpolation, interpolation_from>},
    {"detail", "auto|full|coarse", "auto",
     "full: from all samples; coarse: from every eighth along each axis; auto: coarse if that is "
     "sufficient for the pixels, or if all samples would cost too much",
     set_word<&N::detail, slice_detail_from>},
    {"format", "png|raw", "png",
     "png: colors, transparent where there is no field; raw: 32-bit floats, little-endian, row by "
     "row, NaN where there is no field",
     set_word<&S::format, format_from>},
    {"window", "a number greater than 0", "",
     "Width of the range of displayed values; default: that of the data",
     set_word<&S::window, window_from>},
    {"level", "a number", "", "Middle of the range of displayed values",
     set_word<&S::level, decimal_from>},
    {"colors", "gray|viridis|cividis|coolwarm", "gray",
     "Colors from the smallest to the largest value", set_word<&S::colors, color_map_from>},
    {"color_scale", "linear|log", "linear",
     "linear: equal differences of values are equal steps of color; log: equal factors are; "
     "requires values above 0",
     set_word<&S::is_logarithmic, is_logarithmic_from>},
    {"no_value_color", "a color, RRGGBB", "",
     "RRGGBB: the color of places without a value; default: transparent",
     set_word<&S::no_value_color, rgb_from>}};

constexpr QueryField<P> kProbeFields[] = {
    {"at", kThreeNumbers, "", "X,Y,Z of a place, once for each; at most 1024", add_place,
     /*is_repeatable=*/true, /*is_required=*/true},
    {"coordinates", "world|index", "world", "Coordinates of the places",
     set_word<&P::coordinates, coordinate_system_from>}};

}  // namespace

std::span<const QueryField<SliceQuery>> slice_fields() { return kSliceFields; }

std::span<const QueryField<ProbeRequest>> probe_fields() { return kProbeFields; }

Result<SliceQuery> parse_slice_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parse_query<SliceQuery>(query, slice_fields());
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
  auto probe = parse_query<ProbeRequest>(query, probe_fields());
  if (!probe) return probe;
  if (probe->places.empty()) {
    return fail(ErrorCode::kInvalidArgument, "Give a place with at=X,Y,Z, once or several times.");
  }
  return validated(*probe);
}

}  // namespace multitetra
