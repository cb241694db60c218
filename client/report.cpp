#include "client/report.hpp"

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace multitetra {
namespace {

using Json = nlohmann::ordered_json;

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

std::string human_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  double value = static_cast<double>(bytes) / 1024;
  const char* unit = "KiB";
  for (const char* larger : {"MiB", "GiB", "TiB"}) {
    if (value < 1024) break;
    value /= 1024;
    unit = larger;
  }
  return format("%.1f %s", value, unit);
}

// 1234567 -> "1 234 567"
std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ' ');
  return digits;
}

Json parameters(const IsosurfaceRequest& request) {
  return {{"isovalue", request.isovalue},
          {"error", request.error},
          {"unit", name(request.unit)},
          {"bound", name(request.measure)},
          {"topology_rule", name(request.topology_rule)},
          {"topology_tolerance", request.topology_tolerance},
          {"lattice_resolution", request.lattice_resolution}};
}

Json step_json(const FetchedStep& fetched) {
  const StepBegin& begin = fetched.step->begin;
  const StepEnd& end = fetched.step->end;
  const MeshTopology& topology = fetched.step->topology;
  return {{"step", begin.step},
          {"final", begin.is_final},
          {"parameters", parameters(begin.request)},
          {"error_bound_world", begin.error_bound_world},
          {"finest_spacing", begin.finest_spacing},
          {"tetrahedra", begin.tetrahedra},
          {"active_tetrahedra", begin.active_tetrahedra},
          {"triangles", topology.triangles},
          {"vertices", topology.vertices},
          {"euler_characteristic", topology.euler_characteristic},
          {"components", topology.components},
          {"border_edges", topology.border_edges},
          {"open_edges", topology.open_edges},
          {"nonmanifold_edges", topology.nonmanifold_edges},
          {"tiles", begin.tiles.size()},
          {"tiles_received", end.tiles_sent},
          {"bytes", end.payload_bytes},
          {"first_byte_seconds", fetched.first_byte_seconds},
          {"seconds", fetched.seconds},
          {"server_seconds", end.seconds},
          {"content_digest", end.digest.hex()},
          {"checks", fetched.step->checks}};
}

Json dataset_json(const DatasetInfo& info) {
  return {{"name", info.name},
          {"dims", info.dims},
          {"type", name(info.type)},
          {"spacing", info.spacing},
          {"min", info.min},
          {"max", info.max},
          {"void_samples", info.void_samples},
          {"outside", info.outside ? Json(*info.outside) : Json(nullptr)},
          {"margin", info.margin},
          {"grid_exponent", info.grid_exponent},
          {"index_to_world",
           {{"columns", info.index_to_world.columns},
            {"translation", info.index_to_world.translation}}},
          {"suggested_isovalues", info.suggested_isovalues},
          {"histogram",
           {{"low", info.histogram.low},
            {"high", info.histogram.high},
            {"counts", info.histogram.counts}}}};
}

// Bytes that are no UTF-8, in names from a server, are replaced and not thrown about.
std::string text_of(const Json& json) {
  return json.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string json_report(const FetchReport& report) {
  Json steps = Json::array();
  for (const FetchedStep& step : report.steps) steps.push_back(step_json(step));
  return text_of({{"server", to_string(report.server)},
                  {"dataset", report.open.dataset},
                  {"parameters", parameters(report.open.request)},
                  {"final_only", report.open.steps == StepPolicy::kFinalOnly},
                  {"coordinates", report.coordinates},
                  {"mesh_file", report.mesh_file},
                  {"steps", std::move(steps)}});
}

std::string json_list(const Endpoint& server, const std::vector<DatasetInfo>& datasets) {
  Json list = Json::array();
  for (const DatasetInfo& info : datasets) list.push_back(dataset_json(info));
  return text_of({{"server", to_string(server)}, {"datasets", std::move(list)}});
}

std::string step_line(const FetchedStep& fetched) {
  const StepBegin& begin = fetched.step->begin;
  const MeshTopology& topology = fetched.step->topology;
  return format("step %u%s: error %g %s, %zu tiles, ", begin.step, begin.is_final ? " (final)" : "",
                begin.request.error, std::string(name(begin.request.unit)).c_str(),
                begin.tiles.size()) +
         grouped(static_cast<std::uint64_t>(topology.triangles)) + " triangles, " +
         human_bytes(fetched.step->end.payload_bytes) + format(", %.2f s", fetched.seconds);
}

std::string text_list(const std::vector<DatasetInfo>& datasets) {
  std::string text;
  for (const DatasetInfo& info : datasets) {
    const std::string isovalue = info.suggested_isovalues.empty()
                                     ? std::string("none")
                                     : format("%g", info.suggested_isovalues.front());
    text += info.name +
            format("  %d x %d x %d %s  values %g to %g  suggested isovalue ", info.dims[0],
                   info.dims[1], info.dims[2], std::string(name(info.type)).c_str(), info.min,
                   info.max) +
            isovalue + "\n";
  }
  return text;
}

}  // namespace multitetra
