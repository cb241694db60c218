#include "client/library/report.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"

namespace multitetra {
namespace {

Json step_json(const FetchedStep& fetched) {
  const StepBegin& begin = fetched.step->begin;
  const StepEnd& end = fetched.step->end;
  Json json = {{"step", begin.step},
               {"final", begin.is_final},
               {"parameters", json_of(begin.request)},
               {"error_bound_world",
                begin.finest_spacing > 1 ? Json(nullptr) : Json(begin.error_bound_world)},
               {"simplification_bound_world", simplification_bound(begin)},
               {"finest_spacing", begin.finest_spacing},
               {"codec", begin.shell ? "sample_shell" : "draco"},
               {"tetrahedra", begin.tetrahedra},
               {"active_tetrahedra", begin.active_tetrahedra}};
  json.update(json_of(fetched.step->topology));
  json["tiles"] = begin.tiles.size();
  json["tiles_received"] = end.tiles_sent;
  json["bytes"] = end.payload_bytes;
  json["first_byte_seconds"] = fetched.first_byte_seconds;
  json["seconds"] = fetched.seconds;
  json["server_seconds"] = end.seconds;
  json["content_digest"] = end.digest.hex();
  json["checks"] = fetched.step->checks;
  return json;
}

// Returns the error that the step allows, which may exceed the requested one within a budget.
// Previews have a spacing instead of a bound.
std::string accuracy_of(const StepBegin& begin, const DatasetInfo& info) {
  if (begin.finest_spacing > 1)
    return "1 in " + std::to_string(begin.finest_spacing) + " samples per axis";
  const IsosurfaceRequest& request = begin.request;
  if (!request.thresholds.is_uniform()) {
    return "errors up to " + human_error(begin.error_bound_world, request.unit, info);
  }
  const double error = std::max(request.error, request.thresholds.error_floor);
  if (request.unit == ErrorUnit::kWorld) {
    return "error " + human_length(error, info.meaning.length_unit);
  }
  return "error " + human_number(error) + (error == 1 ? " voxel" : " voxels");
}

}  // namespace

double simplification_bound(const StepBegin& begin) {
  double bound = 0;
  for (const TileSummary& tile : begin.tiles) bound = std::max(bound, tile.simplification_bound);
  return bound;
}

WholeSurface whole_surface(const CommittedStep& step) {
  return {.topology = step.topology,
          .tetrahedra = step.begin.tetrahedra,
          .active_tetrahedra = step.begin.active_tetrahedra,
          .tiles = step.begin.tiles.size(),
          .error_bound = distance_bound(step.begin),
          .simplification_bound = simplification_bound(step.begin),
          .digest = step.end.digest};
}

Json json_of(const FetchReport& report) {
  SurfaceReport surface = report.surface;
  surface.dataset = report.open.dataset;
  surface.request = report.open.request;
  if (!report.steps.empty() && report.steps.back().step->begin.is_final) {
    const CommittedStep& step = *report.steps.back().step;
    surface.surface = whole_surface(step);
    surface.request = step.begin.request;
    surface.colors = step.begin.scalars;
  }
  if (report.open.scalars) surface.color_by = report.open.scalars->dataset;
  Json steps = Json::array();
  for (const FetchedStep& step : report.steps) steps.push_back(step_json(step));
  surface.more = {{"server", to_string(report.server)},
                  {"final_only", report.open.steps == StepPolicy::kFinalOnly},
                  {"tiles_held", report.tiles_held},
                  {"tiles_received", report.received.tiles},
                  {"bytes_received", report.received.payload_bytes},
                  {"reconnections", report.reconnections},
                  {"steps", std::move(steps)}};
  if (report.error) {
    surface.more["error"] = {{"code", name(report.error->code)}, {"text", report.error->text}};
  }
  return json_of(surface);
}

std::string json_list(const Endpoint& server, const std::vector<DatasetInfo>& datasets) {
  Json list = Json::array();
  for (const DatasetInfo& info : datasets) list.push_back(json_of(info));
  return text_of({{"server", to_string(server)}, {"datasets", std::move(list)}});
}

std::string step_line(const FetchedStep& fetched, const DatasetInfo& info) {
  const StepBegin& begin = fetched.step->begin;
  const auto triangles = static_cast<std::uint64_t>(fetched.step->topology.triangles);
  const std::string kind = begin.is_final             ? " (final)"
                           : begin.finest_spacing > 1 ? " (preview)"
                           : begin.shell              ? " (samples)"
                                                      : " (unsimplified)";
  return "step " + std::to_string(begin.step) + kind + ": " + "isovalue " +
         shortest_text(begin.request.isovalue) + ", " + accuracy_of(begin, info) + ", " +
         human_count_of(begin.tiles.size(), "tile") + ", " + human_count_of(triangles, "triangle") +
         ", " + human_bytes(fetched.step->end.payload_bytes) + ", " +
         human_seconds(fetched.seconds);
}

namespace {

// Returns "6 datasets: 3 times, 2 fields".
std::string summary_of(const std::vector<const DatasetInfo*>& members) {
  std::set<double> times, labels;
  std::set<std::string> fields;
  for (const DatasetInfo* info : members) {
    const SeriesMember& member = *info->member;
    if (member.time) times.insert(*member.time);
    if (member.label) labels.insert(member.label->value);
    if (!member.field.empty()) fields.insert(member.field);
  }
  std::string text = human_count_of(members.size(), "dataset");
  std::string between = ": ";
  for (const auto& [count, what] :
       {std::pair(times.size(), "time"), {fields.size(), "field"}, {labels.size(), "label"}}) {
    if (count == 0) continue;
    text += std::exchange(between, ", ") + human_count_of(count, what);
  }
  return text;
}

}  // namespace

std::string checks_table(const std::vector<FetchedStep>& steps) {
  std::string table;
  const auto row = [&](const std::string& what, const auto& cell) {
    constexpr std::size_t kFirstColumn = 26;
    constexpr std::size_t kColumn = 12;
    const auto padded = [](std::size_t width, const std::string& text) {
      return std::string(width > text.size() ? width - text.size() : 1, ' ');
    };
    table += what + padded(kFirstColumn, what);
    for (const FetchedStep& fetched : steps) {
      const std::string text = cell(*fetched.step);
      table += padded(kColumn, text) + text;
    }
    table += "\n";
  };
  const auto count = [](std::int64_t n) { return human_count(static_cast<std::uint64_t>(n)); };
  row("check", [](const CommittedStep& s) {
    return s.begin.is_final ? std::string("final") : "step " + std::to_string(s.begin.step);
  });
  row("tiles and digests", [](const CommittedStep&) { return "ok"; });  // Committed steps only.
  row("open edges", [&](const CommittedStep& s) { return count(s.topology.open_edges); });
  row("non-manifold edges",
      [&](const CommittedStep& s) { return count(s.topology.nonmanifold_edges); });
  row("edges on the border",
      [&](const CommittedStep& s) { return count(s.topology.border_edges); });
  row("components", [&](const CommittedStep& s) { return count(s.topology.components); });
  row("Euler characteristic",
      [](const CommittedStep& s) { return std::to_string(s.topology.euler_characteristic); });
  row("topology preserved", [](const CommittedStep& s) {
    if (s.topology.triangles == 0) return "empty";
    return preserves_topology(s.begin) ? "yes" : s.begin.finest_spacing > 1 ? "preview" : "no";
  });
  return table;
}

namespace {

// Returns the range of the values of all members, which must be of one field.
std::string values_of(const std::vector<const DatasetInfo*>& members) {
  DatasetInfo all = *members.front();
  for (const DatasetInfo* const info : members) {
    if (info->member->field != all.member->field) return "of several fields";
    all.min = std::min(all.min, info->min);
    all.max = std::max(all.max, info->max);
  }
  return human_value(all.min, all) + " to " + human_value(all.max, all);
}

}  // namespace

std::string text_list(const std::vector<DatasetInfo>& datasets, const std::string& series) {
  const auto series_of = [](const DatasetInfo& info) {
    return info.member ? info.member->series : std::string();
  };
  std::map<std::string, std::vector<const DatasetInfo*>> members;
  for (const DatasetInfo& info : datasets) members[series_of(info)].push_back(&info);
  const bool has_series = members.size() > members.count("");
  std::vector<std::vector<std::string>> rows = {
      {"DATASET", "SAMPLES", "TYPE", "VALUES", "SUGGESTED ISOVALUES"}};
  if (has_series) rows.front().push_back(series.empty() ? "SERIES OF" : "MEMBER OF SERIES");
  std::set<std::string> listed;
  for (const DatasetInfo& info : datasets) {
    const std::string in = series_of(info);
    const bool is_left_out =
        series.empty() ? !in.empty() && !listed.insert(in).second : in != series;
    if (is_left_out) continue;
    const bool is_series = series.empty() && !in.empty();
    rows.push_back({printable(is_series ? in : info.name), sides_text(info.dims),
                    std::string(name(info.type)),
                    is_series ? values_of(members[in])
                              : human_value(info.min, info) + " to " + human_value(info.max, info),
                    human_suggestions(info)});
    if (!has_series) continue;
    rows.back().push_back(is_series        ? summary_of(members[in])
                          : series.empty() ? "-"
                                           : printable(human_member(*info.member)));
  }
  if (datasets.empty()) return "This server has no dataset that this client may see.\n";
  if (rows.size() == 1) return "No series is named \"" + printable(series) + "\".\n";
  return text_table(rows);
}

}  // namespace multitetra
