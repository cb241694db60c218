#include "common/surface_options.hpp"

namespace multitetra {

void add_surface_options(CLI::App& command, SurfaceArguments& a) {
  command.add_option("--isovalue", a.isovalue,
                     "Value of the surface (default: the dataset's first suggestion)");
  command.add_option("--error", a.error, "Largest allowed error; 0 is the full resolution")
      ->capture_default_str();
  command.add_option("--unit", a.unit, "Unit of --error; 1 voxel is the smallest spacing")
      ->check(CLI::IsMember({"voxel", "world"}))
      ->capture_default_str();
  command.add_option("--bound", a.bound, "certified bounds the real distance, paper need not")
      ->check(CLI::IsMember({"paper", "certified"}))
      ->capture_default_str();
  command
      .add_option("--topology-rule", a.topology_rule,
                  "Which flips of sign are kept: those that change topology (exact) or all (paper)")
      ->check(CLI::IsMember({"exact", "paper"}))
      ->capture_default_str();
  command
      .add_option("--topology-tolerance", a.topology_tolerance,
                  "Features up to this many voxels may vanish; 0 preserves the topology")
      ->capture_default_str();
  command
      .add_option("--lattice", a.lattice_resolution,
                  "Vertices lie on a lattice of 2^-R grid steps, R from 1 to 8")
      ->capture_default_str();
  command
      .add_option("--coordinates", a.coordinates, "Of the mesh: world, or index for sample indices")
      ->check(CLI::IsMember({"world", "index"}))
      ->capture_default_str();
}

Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (!arguments.isovalue && info.suggested_isovalues.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Dataset \"" + info.name + "\" suggests no isovalue; name one with --isovalue.");
  }
  return validated(
      {.isovalue = arguments.isovalue ? *arguments.isovalue : info.suggested_isovalues.front(),
       .error = arguments.error,
       .unit = length_unit_from(arguments.unit).value_or(LengthUnit::kVoxel),
       .measure = error_measure_from(arguments.bound).value_or(ErrorMeasure::kCertified),
       .topology_rule = topology_rule_from(arguments.topology_rule).value_or(TopologyRule::kExact),
       .topology_tolerance = arguments.topology_tolerance,
       .lattice_resolution = arguments.lattice_resolution});
}

Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info) {
  return arguments.coordinates == "world" ? grid_to_world(info) : grid_to_index(info);
}

}  // namespace multitetra
