#include "common/cli/surface_options.hpp"

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/cli/human_units.hpp"
#include "common/mesh/components.hpp"
#include "common/request/threshold_parser.hpp"

namespace multitetra {

namespace {

constexpr const char* kSurface = "Surface";
constexpr const char* kThresholds = "Errors that differ from place to place";
constexpr const char* kSize = "Size";

void add_threshold_options(Command& command, SurfaceArguments& a) {
  command
      .add_option("--region", a.regions,
                  "Another error in a region, the last that contains a place wins (repeatable): "
                  "box:X0,Y0,Z0,X1,Y1,Z1=TAU, ball:X,Y,Z,R=TAU or halfspace:NX,NY,NZ,D=TAU for "
                  "the places with N.x >= D; TAU in --unit")

      ->type_name("REGION")
      ->group(kThresholds)
      ->repeatable();
  command
      .add_option("--region-unit", a.region_unit,
                  "Of the coordinates of --region and --view: world, or index for sample indices")
      ->one_of({"world", "index"})
      ->capture_default_str()
      ->group(kThresholds);
  command
      .add_option("--view", a.view,
                  "Errors that look the same on a screen: "
                  "eye=X,Y,Z,fov=DEGREES,height=PIXELS,pixels=TOLERANCE; for more error outside "
                  "the picture also look=X,Y,Z,outside=TAU[,up=X,Y,Z][,aspect=RATIO]")
      ->type_name("VIEW")
      ->group(kThresholds);
  command
      .add_option(
          "--threshold-grid", a.threshold_grid,
          std::string("Image whose samples are errors in --unit, each for its voxel; NaN: none. ") +
              a.threshold_files.formats)
      ->type_name("FILE")
      ->group(kThresholds);
  command
      .add_option("--combine", a.combination,
                  "order: regions over the view over the grid over --error; minimum: the least of "
                  "those that say something")
      ->one_of({"order", "minimum"})
      ->capture_default_str()
      ->group(kThresholds);
}

void add_budget_options(Command& command, SurfaceArguments& a) {
  command
      .add_option("--simplify", a.simplify,
                  "on: meshes with a few of the triangles, within the same errors; off: all that "
                  "marching tetrahedra makes")
      ->one_of({"on", "off"})
      ->capture_default_str()
      ->group(kSize);
  command
      .add_flag("--embedded", a.embedded,
                "Simplified meshes that nowhere cut themselves, in two to four times the time")
      ->group(kSize);
  command
      .add_option("--max-triangles", a.max_triangles,
                  "The most triangles of each step, as 2M or 300k; errors are raised to meet it "
                  "(default: no limit)")
      ->as_count()
      ->type_name("COUNT")
      ->group(kSize);
  command
      .add_option("--max-bytes", a.max_bytes,
                  "The most bytes of compressed mesh of the final step, and of each preview, as "
                  "500KiB or 2MiB; errors are raised until it is met, and most of it used "
                  "(0.7, where errors a fifth apart allow) (default: no limit)")
      ->as_bytes()
      ->type_name("BYTES")
      ->group(kSize);
  command
      .add_option("--normals", a.normal_bits,
                  "Bits of each coordinate of the vertices' normals, 8 to 10; 0: no normals")
      ->capture_default_str()
      ->type_name("BITS")
      ->group(kSize);
}

Result<LocalThresholds> thresholds_of(const SurfaceArguments& arguments) {
  LocalThresholds thresholds{
      .coordinates =
          coordinate_system_from(arguments.region_unit).value_or(CoordinateSystem::kWorld),
      .combination = combination_from(arguments.combination).value_or(Combination::kInOrder)};
  for (const std::string& word : arguments.regions) {
    const auto region = parse_region(word);
    if (!region) return tl::unexpected(region.error());
    thresholds.regions.push_back(*region);
  }
  if (!arguments.view.empty()) {
    const auto view = parse_view(arguments.view);
    if (!view) return tl::unexpected(view.error());
    thresholds.view = *view;
  }
  if (!arguments.threshold_grid.empty()) {
    auto grid = arguments.threshold_files.read(arguments.threshold_grid, arguments.error);
    if (!grid) return tl::unexpected(grid.error());
    thresholds.grid = std::make_shared<const ThresholdGrid>(*std::move(grid));
  }
  return thresholds;
}

}  // namespace

void add_surface_options(Command& command, SurfaceArguments& a, Isovalues isovalues) {
  const std::string first = "(default: the dataset's first suggestion)";
  if (isovalues == Isovalues::kOne) {
    command
        .add_option("--isovalue", a.isovalues,
                    "Value of the surface, in units of the samples " + first)
        ->expected(1)
        ->type_name("FLOAT")
        ->group(kSurface);
  } else {
    command
        .add_option("--isovalue", a.isovalues,
                    "Value of the surface, in units of the samples; several with commas between "
                    "them are as many surfaces, and a budget is one for all of them " +
                        first)
        ->repeatable()
        ->delimiter(',')
        ->type_name("FLOAT,...")
        ->group(kSurface);
  }
  command
      .add_option("--error", a.error,
                  "Largest allowed error where nothing else is said; 0 is the full resolution")
      ->capture_default_str()
      ->group(kSurface);
  command
      .add_option(
          "--unit", a.unit,
          "Unit of all errors: voxel, the smallest spacing, or world, the unit of the dataset's "
          "world coordinates, as mm (`info` and `list --json` tell it)")
      ->one_of({"voxel", "world"})
      ->capture_default_str()
      ->group(kSurface);
  command.add_option("--bound", a.bound, "certified bounds the real distance, paper need not")
      ->one_of({"paper", "certified"})
      ->capture_default_str()
      ->group(kSurface);
  command
      .add_option("--topology-rule", a.topology_rule,
                  "Which flips of sign are kept: those that change topology (exact) or all (paper)")
      ->one_of({"exact", "paper"})
      ->capture_default_str()
      ->group(kSurface);
  command
      .add_option("--topology-tolerance", a.topology_tolerance,
                  "Features up to this many voxels may vanish; 0 preserves the topology")
      ->capture_default_str()
      ->type_name("VOXELS")
      ->group(kSurface);
  command
      .add_option("--lattice", a.lattice_resolution,
                  "Vertices lie on a lattice of 2^-R grid steps, R from 1 to 8")
      ->capture_default_str()
      ->type_name("R")
      ->group(kSurface);
  command
      .add_option("--coordinates", a.coordinates, "Of the mesh: world, or index for sample indices")
      ->one_of({"world", "index"})
      ->capture_default_str()
      ->group(kSurface);
  command
      .add_option("--space", a.space,
                  "Axes of the mesh's world coordinates: native as the dataset has them (`info` "
                  "tells which), lps to the patient's left, back and head, ras to right, front and "
                  "head")
      ->one_of({"native", "lps", "ras"})
      ->capture_default_str()
      ->group(kSurface);
  add_threshold_options(command, a);
  add_budget_options(command, a);
}

void add_output_options(Command& command, SurfaceArguments& a) {
  command
      .add_flag("--allow-empty", a.allow_empty,
                "Write a surface without a triangle as well; otherwise nothing is written then, "
                "and the exit code is 6")
      ->group(kSurface);
  command
      .add_option(
          "--min-component", a.min_component,
          "Leave out connected components whose bounding box has a shorter diagonal, as the "
          "dust that noise makes; 0 leaves out none. Checks and digests are of the whole "
          "surface")
      ->within(0.0, 1e6)
      ->type_name("SAMPLES")
      ->capture_default_str()
      ->group(kSurface);
}

namespace {

// That the mesh can be written in the space that was asked for.
Result<void> check_space(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.space == "native") return {};
  if (arguments.coordinates != "world") {
    return fail(ErrorCode::kInvalidArgument,
                "--space is about world coordinates; it has no meaning with --coordinates index.");
  }
  if (info.meaning.space != WorldSpace::kUnnamed) return {};
  return fail(ErrorCode::kInvalidArgument,
              "--space: nobody knows how the world axes of \"" + info.name +
                  "\" lie in a patient, because its file did not tell; leave --space native.");
}

}  // namespace

Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments, const DatasetInfo& info) {
  auto requests = requests_of(arguments, info);
  if (!requests) return tl::unexpected(requests.error());
  return requests->front();
}

Result<std::vector<IsosurfaceRequest>> requests_of(const SurfaceArguments& arguments,
                                                   const DatasetInfo& info) {
  if (const auto checked = check_space(arguments, info); !checked) {
    return tl::unexpected(checked.error());
  }
  std::vector<double> isovalues = arguments.isovalues;
  if (isovalues.empty() && info.suggested_isovalues.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Dataset \"" + info.name + "\" suggests no isovalue; name one with --isovalue.");
  }
  if (isovalues.empty()) isovalues.push_back(info.suggested_isovalues.front());
  auto thresholds = thresholds_of(arguments);
  if (!thresholds) return tl::unexpected(thresholds.error());
  std::vector<IsosurfaceRequest> requests;
  for (const double isovalue : isovalues) {
    auto request = validated(
        {.isovalue = isovalue,
         .error = arguments.error,
         .unit = length_unit_from(arguments.unit).value_or(LengthUnit::kVoxel),
         .measure = error_measure_from(arguments.bound).value_or(ErrorMeasure::kCertified),
         .topology_rule =
             topology_rule_from(arguments.topology_rule).value_or(TopologyRule::kExact),
         .topology_tolerance = arguments.topology_tolerance,
         .lattice_resolution = arguments.lattice_resolution,
         .thresholds = *thresholds,
         .max_triangles = arguments.max_triangles,
         .max_bytes = arguments.max_bytes,
         .simplify = arguments.simplify == "on",
         .embedded = arguments.embedded,
         .normal_bits = arguments.normal_bits});
    if (!request) return tl::unexpected(request.error());
    requests.push_back(*std::move(request));
  }
  return requests;
}

namespace {

// Whether world coordinates change from LPS to RAS or back: then x and y change their directions.
bool is_turned(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.coordinates != "world" || arguments.space == "native") return false;
  return info.meaning.space != (arguments.space == "lps" ? WorldSpace::kLps : WorldSpace::kRas);
}

}  // namespace

Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.coordinates != "world") return grid_to_index(info);
  Affine map = grid_to_world(info);
  if (!is_turned(arguments, info)) return map;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (Vec3& column : map.columns) column[axis] = -column[axis];
    map.translation[axis] = -map.translation[axis];
  }
  return map;
}

OutputSurface output_surface(const LatticeMesh& mesh, const SurfaceArguments& arguments,
                             const DatasetInfo& info) {
  const MeshComponents components = components_of(mesh);
  const Affine map = output_map(arguments, info);
  OutputSurface output{.mesh = {},
                       .components = components.count_from(arguments.min_component),
                       .components_of = components.diagonals.size()};
  output.mesh = output.components == output.components_of
                    ? positioned(mesh, map)
                    : positioned(with_components(mesh, components, arguments.min_component), map);
  const std::uint32_t largest = components.largest();
  std::uint32_t number = 0;
  for (const std::uint32_t component : components.of_vertex) {
    if (components.diagonals[component] < arguments.min_component) continue;
    if (component == largest) output.largest.push_back(number);
    ++number;
  }
  if (is_turned(arguments, info)) {
    for (UnitVector& normal : output.mesh.normals) normal = {-normal[0], -normal[1], normal[2]};
  }
  return output;
}

std::string left_out_text(const OutputSurface& surface, const SurfaceArguments& arguments) {
  if (surface.components == surface.components_of) return {};
  return human_count(surface.components) + " of " + human_count(surface.components_of) +
         " components, those with a diagonal of " + human_number(arguments.min_component) +
         " samples or more";
}

}  // namespace multitetra
