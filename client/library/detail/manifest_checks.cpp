#include "client/library/detail/manifest_checks.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "common/mesh/merged_tiles.hpp"

namespace multitetra {
namespace {

std::optional<std::string> budget_fault(const StepBegin& begin,
                                        const IsosurfaceRequest& requested) {
  ManifestTotals totals;
  for (const TileSummary& tile : begin.tiles) totals.add(tile);
  if (requested.max_triangles > 0 && totals.triangles > requested.max_triangles) {
    return "it has " + std::to_string(totals.triangles) + " triangles, more than the budget of " +
           std::to_string(requested.max_triangles);
  }
  if (requested.max_bytes > 0 && totals.payload_bytes > requested.max_bytes) {
    return "it has " + std::to_string(totals.payload_bytes) + " bytes, more than the budget of " +
           std::to_string(requested.max_bytes);
  }
  return std::nullopt;
}

// Previews may be coarser than the request; all other parameters must match it.
std::optional<std::string> parameter_fault(const StepBegin& begin,
                                           const IsosurfaceRequest& requested) {
  IsosurfaceRequest given = begin.request;
  if (begin.is_final) {
    if (const auto beyond = budget_fault(begin, requested)) return beyond;
    if (has_budget(requested)) {
      // Within a budget the final step may be coarser than requested, and states its error.
      given.thresholds.error_floor = requested.thresholds.error_floor;
      given.topology_tolerance = requested.topology_tolerance;
    }
    if (given != requested) return "the parameters of the final step differ from the request";
    if (begin.request.thresholds.error_floor < requested.thresholds.error_floor ||
        begin.request.topology_tolerance < requested.topology_tolerance) {
      return "the final step is finer than the request";
    }
    if (begin.finest_spacing != 1) return "the final step omits the finest points";
    return std::nullopt;
  }
  if (!(given.error >= requested.error)) return "a preview's error is below the request's";
  if (!(given.topology_tolerance >= requested.topology_tolerance)) {
    return "a preview's topology tolerance is below the request's";
  }
  if (given.lattice_resolution > requested.lattice_resolution) {
    return "a preview's lattice is finer than the request's";
  }
  if (!(given.thresholds.error_floor >= requested.thresholds.error_floor)) {
    return "a preview's least threshold is below the request's";
  }
  given.lattice_resolution = requested.lattice_resolution;
  given.thresholds.error_floor = requested.thresholds.error_floor;
  given.error = requested.error;
  given.topology_tolerance = requested.topology_tolerance;
  if (given != requested) return "a preview differs from the request in more than its accuracy";
  return std::nullopt;
}

// parse_server_message() has checked that no number is negative.
bool is_in_grid(const OctreeCube& cube, int grid_exponent) {
  return cube.exponent <= grid_exponent &&
         std::max({cube.x, cube.y, cube.z}) < std::int32_t{1} << (grid_exponent - cube.exponent);
}

// The distance moved by simplification is part of the step's error bound.
std::optional<std::string> simplification_fault(const TileSummary& tile, const StepBegin& begin) {
  if (tile.simplification_bound == 0) return std::nullopt;
  if (!begin.request.simplify)
    return "it is simplified, although the request forbids simplification";
  if (tile.simplification_bound <= begin.error_bound_world) return std::nullopt;
  return "simplification moved it by up to " + std::to_string(tile.simplification_bound) +
         ", more than the step's error bound of " + std::to_string(begin.error_bound_world);
}

// Sample shells carry only samples, and their error bound follows from them.
std::optional<std::string> shell_fault(const StepBegin& begin, const OpenStream& open,
                                       const DatasetInfo& info) {
  if (open.request.cell || open.request.normal_bits != 0 || open.scalars) {
    return "it has sample shells, which cannot have cells, normals or scalars";
  }
  if (begin.is_final && open.use == MeshUse::kKeep) {
    return "the final step has sample shells, although the client keeps its mesh";
  }
  std::vector<OctreeCube> cubes;
  for (const TileSummary& tile : begin.tiles) cubes.push_back(tile.cube);
  if (!are_disjoint(cubes)) return "the cubes of its sample shells overlap";
  // Other machines may round exponential functions differently.
  constexpr double kRounding = 1e-9;
  const double bound = error_bound(*begin.shell, info, begin.finest_spacing);
  if (std::abs(begin.error_bound_world - bound) <= kRounding * bound) return std::nullopt;
  return "its stated error bound is " + std::to_string(begin.error_bound_world) +
         ", that of its shells is " + std::to_string(bound);
}

std::string too_many(const char* what, std::uint64_t count, std::uint64_t limit) {
  return "it announces " + std::to_string(count) + " " + what + "; this client allows " +
         std::to_string(limit);
}

}  // namespace

void ManifestTotals::add(const TileSummary& tile) {
  ++tiles;
  triangles += tile.triangles;
  payload_bytes += tile.bytes;
}

std::optional<std::string> exceeded_limits(const ManifestTotals& totals,
                                           const AssemblerLimits& limits) {
  if (totals.tiles > limits.tiles) return too_many("tiles", totals.tiles, limits.tiles);
  if (totals.triangles > limits.triangles) {
    return too_many("triangles", totals.triangles, limits.triangles);
  }
  if (totals.payload_bytes > limits.payload_bytes) {
    return too_many("bytes", totals.payload_bytes, limits.payload_bytes);
  }
  return std::nullopt;
}

tl::unexpected<Error> step_fault(std::uint32_t step, const std::string& what) {
  return fail(ErrorCode::kDamagedData,
              "Step " + std::to_string(step) + ": " + what + (what.ends_with('.') ? "" : "."));
}

std::string tile_name(const StepBegin& begin, std::size_t index) {
  return "tile " + std::to_string(index) + " (" + to_string(begin.tiles[index].cube) + ")";
}

std::optional<std::string> manifest_fault(const StepBegin& begin, const OpenStream& open,
                                          const DatasetInfo& info, const AssemblerLimits& limits) {
  if (auto fault = parameter_fault(begin, open.request)) return fault;
  if (begin.shell) {
    if (auto fault = shell_fault(begin, open, info)) return fault;
  }
  if (begin.scalars.has_value() != open.scalars.has_value() ||
      (begin.scalars && begin.scalars->bits != open.scalars->bits)) {
    return "its scalars differ from the request";
  }
  ManifestTotals totals;
  std::set<OctreeCube> cubes;
  std::set<ContentDigest> digests;
  for (std::size_t i = 0; i < begin.tiles.size(); ++i) {
    const TileSummary& tile = begin.tiles[i];
    if (!is_in_grid(tile.cube, info.grid_exponent)) {
      return tile_name(begin, i) + ": it lies outside the grid";
    }
    if (auto fault = simplification_fault(tile, begin)) return tile_name(begin, i) + ": " + *fault;
    if (!cubes.insert(tile.cube).second) return tile_name(begin, i) + " is listed twice";
    if (!digests.insert(tile.digest).second) {
      return tile_name(begin, i) + " has the same content as another tile";
    }
    totals.add(tile);
  }
  return exceeded_limits(totals, limits);
}

}  // namespace multitetra
