#include "common/json_report.hpp"

namespace multitetra {

Json json_of(const IsosurfaceRequest& request) {
  return {{"isovalue", request.isovalue},
          {"error", request.error},
          {"unit", name(request.unit)},
          {"bound", name(request.measure)},
          {"topology_rule", name(request.topology_rule)},
          {"topology_tolerance", request.topology_tolerance},
          {"lattice_resolution", request.lattice_resolution}};
}

Json json_of(const MeshTopology& topology) {
  return {{"triangles", topology.triangles},
          {"vertices", topology.vertices},
          {"euler_characteristic", topology.euler_characteristic},
          {"components", topology.components},
          {"border_edges", topology.border_edges},
          {"open_edges", topology.open_edges},
          {"nonmanifold_edges", topology.nonmanifold_edges},
          {"degenerate_triangles", topology.degenerate_triangles}};
}

Json json_of(const DatasetInfo& info) {
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

std::string text_of(const Json& json) {
  return json.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

}  // namespace multitetra
