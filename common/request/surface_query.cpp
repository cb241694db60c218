#include "common/request/surface_query.hpp"

#include <array>
#include <type_traits>

#include "common/base/parse_number.hpp"
#include "common/mesh/components.hpp"
#include "common/request/shared_budget.hpp"
#include "common/request/threshold_parser.hpp"

namespace multitetra {
namespace {

using F = RequestField;
using Q = SurfaceQuery;
using R = IsosurfaceRequest;
using T = LocalThresholds;

// ---- parsers of values

template <auto Member>
FieldError set_number(const F&, std::string_view text, Q& query) {
  auto& place = member_of<Member>(query);
  const auto value = parse_number<std::remove_reference_t<decltype(place)>>(text);
  if (!value) return "must be a number";
  place = *value;
  return std::nullopt;
}

std::optional<bool> is_on(std::string_view text) {
  if (text == "on" || text == "true") return true;
  if (text == "off" || text == "false") return false;
  return std::nullopt;
}

template <auto Member>
FieldError set_switch(const F&, std::string_view text, Q& query) {
  const auto value = is_on(text);
  if (!value) return "must be on, off, true or false";
  member_of<Member>(query) = *value;
  return std::nullopt;
}

FieldError add_isovalues(const F&, std::string_view text, Q& query) {
  const auto values = parse_number_list<double>(text, 1, SIZE_MAX);
  if (!values) return "must be a number, or several as A,B,C";
  query.isovalues.insert(query.isovalues.end(), values->begin(), values->end());
  return std::nullopt;
}

FieldError set_error(const F& field, std::string_view text, Q& query) {
  query.has_error = true;
  return set_number<&R::error>(field, text, query);
}

FieldError set_quality(const F& field, std::string_view text, Q& query) {
  query.has_quality = true;
  return set_word<&R::error, quality_error_from>(field, text, query);
}

FieldError add_region(const F&, std::string_view text, Q& query) {
  const auto region = parse_region(text);
  if (!region) return region.error().text;
  query.request.thresholds.regions.push_back(*region);
  return std::nullopt;
}

FieldError set_view(const F&, std::string_view text, Q& query) {
  const auto view = parse_view(text);
  if (!view) return view.error().text;
  query.request.thresholds.view = *view;
  return std::nullopt;
}

template <auto Member, auto Parse>
FieldError set_amount(const F& field, std::string_view text, Q& query) {
  const auto amount = Parse(text);
  if (!amount)
    return "must be a whole number, such as " +
           std::string(field.value_syntax == "BYTES" ? "2MiB" : "300k");
  member_of<Member>(query) = *amount;
  return std::nullopt;
}

FieldError set_min_component(const F&, std::string_view text, Q& query) {
  if (text == "largest") {
    query.min_component = kLargestAlone;
    return std::nullopt;
  }
  const auto diagonal = parse_number<double>(text);
  if (!diagonal || !(*diagonal >= 0 && *diagonal <= 1e6))
    return "must be a number of samples from 0 to 1e6, or largest";
  query.min_component = *diagonal;
  return std::nullopt;
}

FieldError set_color_by(const F&, std::string_view text, Q& query) {
  if (text.empty()) return "must be the name of a dataset";
  query.color_by = text;
  return std::nullopt;
}

FieldError set_color_range(const F&, std::string_view text, Q& query) {
  const auto ends = parse_numbers<double>(text, 2);
  if (!ends) return "must be two numbers, LOW,HIGH, such as -10,250.5";
  query.color_range = {ends->front(), ends->back()};
  return std::nullopt;
}

// ---- the table

constexpr auto kSurface = FieldGroup::kSurface;
constexpr auto kThresholds = FieldGroup::kThresholds;
constexpr auto kSize = FieldGroup::kSize;
constexpr auto kColors = FieldGroup::kColors;
constexpr auto kFile = FieldGroup::kFile;
constexpr bool kEveryday = true, kRare = false, kRepeated = true, kOnce = false;

constexpr std::array kFields = {
    F{"isovalue", "NUMBER,...", "", kSurface, kEveryday, kRepeated,
      "Isovalue, or several with commas; default: the dataset's suggestion", add_isovalues},
    F{"error", "NUMBER", "0.25", kSurface, kEveryday, kOnce,
      "Largest distance from the full-resolution surface", set_error},
    F{"quality", "draft|normal|fine|exact", "", kSurface, kEveryday, kOnce,
      "Instead of an error: 2, 0.5, 0.25 or 0 voxels", set_quality},
    F{"unit", "voxel|world", "voxel", kSurface, kEveryday, kOnce,
      "Errors in smallest spacings, or the file's unit", set_word<&R::unit, error_unit_from>},
    F{"bound", "certified|paper", "certified", kSurface, kRare, kOnce,
      "certified bounds the two-sided Hausdorff distance; paper is the estimate of 1997, which the "
      "distance may exceed",
      set_word<&R::error_measure, error_measure_from>},
    F{"topology_rule", "exact|paper", "exact", kSurface, kRare, kOnce,
      "exact: keeps every sign change that changes the topology; paper: keeps all",
      set_word<&R::topology_rule, topology_rule_from>},
    F{"topology_tolerance", "VOXELS", "0", kSurface, kRare, kOnce,
      "Features up to this size may vanish; 0 preserves the topology",
      set_number<&R::topology_tolerance>},
    F{"lattice", "R", "5", kSurface, kRare, kOnce,
      "Vertices are rounded to 1 / 2^R of the sample spacing, R from 1 to 8",
      set_number<&R::lattice_resolution>},

    F{"region", "REGION", "", kThresholds, kRare, kRepeated,
      "Another error in a region; the last region that contains a place applies (repeatable): "
      "box:X0,Y0,Z0,X1,Y1,Z1=ERROR, ball:X,Y,Z,R=ERROR or halfspace:NX,NY,NZ,D=ERROR for the "
      "places with N.x >= D",
      add_region},
    F{"region_coordinates", "world|index", "world", kThresholds, kRare, kOnce,
      "Coordinates of regions and view: world, or sample indices",
      set_word<&T::coordinates, coordinate_system_from>},
    F{"view", "VIEW", "", kThresholds, kRare, kOnce,
      "A screen-space error: eye=X,Y,Z,fov=DEGREES,height=PIXELS,pixels=TOLERANCE; with a larger "
      "error outside the picture: look=X,Y,Z,outside=ERROR[,up=X,Y,Z][,aspect=RATIO]",
      set_view},
    F{"combine", "order|minimum", "order", kThresholds, kRare, kOnce,
      "order: regions before the view before the grid before the error; minimum: the smallest "
      "error that applies",
      set_word<&T::combination, combination_from>},

    F{"max_bytes", "BYTES", "", kSize, kRare, kOnce,
      "Most bytes of each step as it is sent, over HTTP of the file, such as 500KiB (KB is the "
      "same); a larger error is used if needed",
      set_amount<&R::max_bytes, parse_bytes>},
    F{"max_triangles", "COUNT", "", kSize, kRare, kOnce,
      "Most triangles, such as 300k; a larger error is used if needed",
      set_amount<&R::max_triangles, parse_count>},
    F{"simplify", "on|off", "on", kSize, kRare, kOnce,
      "on: meshes with far fewer triangles, within the same errors; off: all triangles of marching "
      "tetrahedra",
      set_switch<&R::simplify>},
    F{"intersection_free", "", "off", kSize, kEveryday, kOnce,
      "Simplified meshes without self-intersections; takes two to three times as long",
      set_switch<&R::intersection_free>},
    F{"normals", "BITS", "0", kSize, kRare, kOnce,
      "Bits of each coordinate of the field's normals at the vertices, 8 to 10; 0: none, and .glb "
      "files have those of the triangles",
      set_number<&R::normal_bits>},

    F{"color_by", "DATASET", "", kColors, kEveryday, kOnce,
      "Color by this dataset's values (same coordinates and unit)", set_color_by},
    F{"color_range", "LOW,HIGH", "", kColors, kRare, kOnce,
      "Values that the colors span (default: those of the dataset); values beyond get the end "
      "colors, and the end values in files",
      set_color_range},
    F{"color_anyway", "", "off", kColors, kRare, kOnce,
      "Also color by a dataset with other world axes, another unit of length, or another position",
      set_switch<&Q::color_anyway>},
    F{"colors", "gray|viridis|cividis|coolwarm", "viridis", kColors, kRare, kOnce,
      "Colors from the smallest to the largest value", set_word<&ColorScale::map, color_map_from>},
    F{"color_scale", "linear|log", "linear", kColors, kRare, kOnce,
      "log: equal factors are equal steps of color; requires a range above 0",
      set_word<&ColorScale::is_logarithmic, is_logarithmic_from>},
    F{"no_value_color", "RRGGBB", "808080", kColors, kRare, kOnce,
      "Color where the dataset has no value", set_word<&ColorScale::no_value, rgb_from>},

    F{"coordinates", "world|index", "world", kFile, kRare, kOnce,
      "Coordinates of the mesh: world, or sample indices",
      set_word<&Q::coordinates, coordinate_system_from>},
    F{"codec", "none|meshopt", "none", kFile, kRare, kOnce,
      "Compression of GLB files; meshopt: EXT_meshopt_compression, which rounds positions to "
      "1/65535 of the longest side",
      set_word<&Q::codec, mesh_codec_from>},
    F{"min_component", "SAMPLES", "0", kFile, kRare, kOnce,
      "Remove components with a shorter bounding-box diagonal, in samples whatever the unit; "
      "largest: all but the largest. Walls of enclosed cavities are components too: removal fills "
      "the cavities. Checks and digests apply to the whole surface",
      set_min_component},
};

}  // namespace

std::string alternatives(std::string_view syntax) {
  std::string text(syntax);
  const std::size_t last = text.rfind('|');
  if (last != std::string::npos) text.replace(last, 1, " or ");
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos;)
    text.replace(at, 1, ", ");
  return text;
}

std::string_view title(FieldGroup group) {
  constexpr std::array<std::string_view, 5> kTitles = {
      "Surface", "Errors that differ from place to place", "Size", "Colors", "File"};
  return kTitles[static_cast<std::size_t>(group)];
}

std::span<const RequestField> request_fields() { return kFields; }

std::optional<double> quality_error_from(std::string_view name) {
  if (name == "draft") return 2;
  if (name == "normal") return 0.5;
  if (name == "fine") return 0.25;
  if (name == "exact") return 0;
  return std::nullopt;
}

Result<std::vector<IsosurfaceRequest>> requests_for(const SurfaceQuery& query,
                                                    const DatasetInfo& info) {
  const auto refuse = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  if (query.has_error && query.has_quality) {
    return refuse("error and quality exclude each other: a quality is a named error.");
  }
  if (query.has_quality && query.request.unit != ErrorUnit::kVoxel) {
    return refuse("A quality is an error in voxels; with unit world give an error.");
  }
  if (query.isovalues.empty() && info.suggested_isovalues.empty()) {
    return refuse("Dataset \"" + info.name +
                  "\" has no suggested isovalue; give one with isovalue.");
  }
  std::vector<double> isovalues = query.isovalues;
  if (isovalues.empty()) isovalues.push_back(info.suggested_isovalues.front());
  std::vector<IsosurfaceRequest> requests;
  for (const double isovalue : isovalues) {
    IsosurfaceRequest request = query.request;
    request.isovalue = isovalue;
    auto valid = validated(request);
    if (!valid) return tl::unexpected(valid.error());
    requests.push_back(*std::move(valid));
  }
  if (const auto shared = check_shared_budget(requests); !shared)
    return tl::unexpected(shared.error());
  return requests;
}

Result<std::optional<ScalarRequest>> scalars_for(const SurfaceQuery& query) {
  const auto refuse = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  if (query.color_by.empty()) {
    if (!query.color_range && !query.colors.is_logarithmic) return std::nullopt;
    return refuse("color_range and color_scale need color_by, the dataset that they apply to.");
  }
  if (query.colors.is_logarithmic && !(query.color_range && query.color_range->low > 0)) {
    return refuse("color_scale log needs a color_range LOW,HIGH with both above 0.");
  }
  auto valid = validated(ScalarRequest{
      .dataset = query.color_by, .limits = query.color_range, .in_any_world = query.color_anyway});
  if (!valid) return tl::unexpected(valid.error());
  return *std::move(valid);
}

}  // namespace multitetra
