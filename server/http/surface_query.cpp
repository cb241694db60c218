#include "server/http/surface_query.hpp"

#include <charconv>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "common/request/threshold_words.hpp"

namespace multitetra {
namespace {

// What is wrong with a value, nullopt if nothing is.
using Objection = std::optional<std::string>;
using Setter = std::function<Objection(std::string_view value, SurfaceQuery& query)>;

template <typename Number>
std::optional<Number> number_from(std::string_view text) {
  Number value{};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Sets what `member` of the query refers to.
template <typename Member>
Setter number(Member member) {
  return [member](std::string_view text, SurfaceQuery& query) -> Objection {
    auto& place = member(query);
    const auto value = number_from<std::remove_reference_t<decltype(place)>>(text);
    if (!value) return "is no number that fits here";
    place = *value;
    return std::nullopt;
  };
}

// The same for a value that is one of a few words; `read` gives nullopt for others.
template <typename Member, typename Read>
Setter word(Member member, Read read, std::string words) {
  return [=](std::string_view text, SurfaceQuery& query) -> Objection {
    const auto value = read(text);
    if (!value) return "must be " + words;
    member(query) = *value;
    return std::nullopt;
  };
}

std::optional<bool> is_world(std::string_view text) {
  if (text == "world") return true;
  if (text == "index") return false;
  return std::nullopt;
}

std::optional<bool> is_on(std::string_view text) {
  if (text == "on") return true;
  if (text == "off") return false;
  return std::nullopt;
}

Objection add_region(std::string_view text, SurfaceQuery& query) {
  const auto region = parse_region(text);
  if (!region) return region.error().text;
  query.request.thresholds.regions.push_back(*region);
  return std::nullopt;
}

Objection set_view(std::string_view text, SurfaceQuery& query) {
  const auto view = parse_view(text);
  if (!view) return view.error().text;
  query.request.thresholds.view = *view;
  return std::nullopt;
}

Objection set_isovalue(std::string_view text, SurfaceQuery& query) {
  query.isovalue = number_from<double>(text);
  if (!query.isovalue) return "is no number";
  return std::nullopt;
}

using Q = SurfaceQuery;

const std::map<std::string_view, Setter>& setters() {
  static const std::map<std::string_view, Setter> kSetters = {
      {"isovalue", set_isovalue},
      {"error", number([](Q & q) -> auto& { return q.request.error; })},
      {"unit",
       word(
           [](Q & q) -> auto& { return q.request.unit; }, length_unit_from, "voxel or world")},
      {"bound", word(
                    [](Q & q) -> auto& { return q.request.measure; }, error_measure_from,
                    "certified or paper")},
      {"topology_rule", word(
                            [](Q & q) -> auto& { return q.request.topology_rule; },
                            topology_rule_from, "exact or paper")},
      {"topology_tolerance", number([](Q & q) -> auto& { return q.request.topology_tolerance; })},
      {"lattice", number([](Q & q) -> auto& { return q.request.lattice_resolution; })},
      {"region", add_region},
      {"region_unit", word(
                          [](Q & q) -> auto& { return q.request.thresholds.coordinates; },
                          coordinate_system_from, "world or index")},
      {"view", set_view},
      {"combine", word(
                      [](Q & q) -> auto& { return q.request.thresholds.combination; },
                      combination_from, "order or minimum")},
      {"max_triangles", number([](Q & q) -> auto& { return q.request.max_triangles; })},
      {"max_bytes", number([](Q & q) -> auto& { return q.request.max_bytes; })},
      {"simplify", word(
                       [](Q & q) -> auto& { return q.request.simplify; }, is_on, "on or off")},
      {"normals", number([](Q & q) -> auto& { return q.request.normal_bits; })},
      {"coordinates",
       word(
           [](Q & q) -> auto& { return q.is_in_world; }, is_world, "world or index")},
      {"format", word(
                     [](Q & q) -> auto& { return q.format; },
                     [](std::string_view text) { return mesh_format_from(text); },
                     "glb, ply, stl, obj or drc")}};
  return kSetters;
}

}  // namespace

Result<SurfaceQuery> parse_surface_query(
    const std::vector<std::pair<std::string, std::string>>& query) {
  const auto refuse = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  SurfaceQuery parsed;
  std::set<std::string_view> given;
  for (const auto& [name, value] : query) {
    const auto setter = setters().find(name);
    if (setter == setters().end()) {
      std::string known;
      for (const auto& [one, unused] : setters()) known.append(known.empty() ? "" : ", ") += one;
      return refuse("There is no parameter \"" + name + "\"; those that are: " + known + ".");
    }
    if (!given.insert(setter->first).second && name != "region") {
      return refuse("The parameter " + name + " is there twice.");
    }
    if (const Objection objection = setter->second(value, parsed)) {
      return refuse("The parameter " + name + "=" + value + ": " + *objection + ".");
    }
  }
  return parsed;
}

Result<IsosurfaceRequest> request_for(const SurfaceQuery& query, const DatasetInfo& info) {
  if (!query.isovalue && info.suggested_isovalues.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Dataset \"" + info.name + "\" suggests no isovalue; name one with isovalue=.");
  }
  IsosurfaceRequest request = query.request;
  request.isovalue = query.isovalue ? *query.isovalue : info.suggested_isovalues.front();
  return validated(request);
}

}  // namespace multitetra
