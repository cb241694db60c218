#include "server/routes/detail/slice_query.hpp"

#include <algorithm>

#include "common/base/number_text.hpp"
#include "server/routes/detail/query_parsers.hpp"

namespace multitetra {
namespace {

using S = SliceQuery;

constexpr const char* kThreeNumbers = "must be three numbers, X,Y,Z";

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

template <typename Member>
Setter<S> vector(Member member) {
  return {[member](std::string_view text, S& query) -> FieldError {
    member(query) = vector_from(text);
    if (!member(query)) return kThreeNumbers;
    return std::nullopt;
  }};
}

FieldError set_extent(std::string_view text, S& query) {
  auto& extent = query.slice.extent;
  extent = parse_number_list<double>(text, 1, 2);
  const auto is_length = [](double v) { return v > 0 && v <= kMaxCoordinate; };
  const bool is_good = extent && std::all_of(extent->begin(), extent->end(), is_length);
  if (!is_good) return "must be a width, or a width and a height, WIDTH,HEIGHT, greater than 0";
  return std::nullopt;
}

template <typename Member>
Setter<S> pixels(Member member) {
  return {[member](std::string_view text, S& query) -> FieldError {
    const auto count = parse_number<std::uint32_t>(text);
    if (!count || *count < 2 || *count > kMaxSlicePixels) {
      return "must be a number of pixels, 2 or more";
    }
    member(query) = *count;
    return std::nullopt;
  }};
}

FieldError set_window(std::string_view text, S& query) {
  query.window = parse_number<double>(text);
  if (!query.window || !(*query.window > 0)) return "must be a number greater than 0";
  return std::nullopt;
}

std::optional<SliceFormat> format_from(std::string_view text) {
  if (text == "png") return SliceFormat::kPng;
  if (text == "raw") return SliceFormat::kRaw;
  return std::nullopt;
}

const Setters<S>& slice_setters() {
  static const Setters<S> kSetters = {
      {"axis", word<S>(
                   [](S & q) -> auto& { return q.slice.axis; }, axis_from, "x, y or z")},
      {"at", number<S>([](S & q) -> auto& { return q.slice.at; })},
      {"centre", vector([](S & q) -> auto& { return q.slice.centre; })},
      {"normal", vector([](S & q) -> auto& { return q.slice.normal; })},
      {"up", vector([](S & q) -> auto& { return q.slice.up; })},
      {"extent", {set_extent}},
      {"origin", vector([](S & q) -> auto& { return q.slice.origin; })},
      {"right", vector([](S & q) -> auto& { return q.slice.right; })},
      {"down", vector([](S & q) -> auto& { return q.slice.down; })},
      {"coordinates", word<S>(
                          [](S & q) -> auto& { return q.slice.coordinates; },
                          coordinate_system_from, "world or index")},
      {"width", pixels([](S & q) -> auto& { return q.slice.pixels.width; })},
      {"height", pixels([](S & q) -> auto& { return q.slice.pixels.height; })},
      {"interpolation", word<S>(
                            [](S & q) -> auto& { return q.slice.interpolation; },
                            interpolation_from, "nearest or linear")},
      {"detail", word<S>(
                     [](S & q) -> auto& { return q.slice.detail; }, slice_detail_from,
                     "auto, full or coarse")},
      {"format", word<S>(
                     [](S & q) -> auto& { return q.format; }, format_from, "png or raw")},
      {"window", {set_window}},
      {"level", number<S>([](S & q) -> auto& { return q.level; })},
      {"colors",
       word<S>(
           [](S & q) -> auto& { return q.colors; }, color_map_from, std::string(kColorMapNames))},
      {"color_scale",
       word<S>(
           [](S & q) -> auto& { return q.is_logarithmic; }, is_logarithmic_from, "linear or log")},
      {"no_value_color", {[](std::string_view text, S& query) -> FieldError {
         query.no_value_color = rgb_from(text);
         if (!query.no_value_color) return "must be a color, RRGGBB";
         return std::nullopt;
       }}}};
  return kSetters;
}

}  // namespace

Result<SliceQuery> parse_slice_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  return parse_query<SliceQuery>(query, slice_setters());
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
  using P = ProbeRequest;
  static const Setters<P> kSetters = {
      {"at",
       {[](std::string_view text, P& probe) -> FieldError {
          const auto place = vector_from(text);
          if (!place) return kThreeNumbers;
          probe.places.push_back(*place);
          return std::nullopt;
        },
        /*is_repeatable=*/true}},
      {"coordinates", word<P>(
                          [](P & p) -> auto& { return p.coordinates; }, coordinate_system_from,
                          "world or index")}};
  auto probe = parse_query<P>(query, kSetters);
  if (!probe) return probe;
  if (probe->places.empty()) {
    return fail(ErrorCode::kInvalidArgument, "Give a place with at=X,Y,Z, once or several times.");
  }
  return validated(*probe);
}

}  // namespace multitetra
