#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "server/certify/certificate_report.hpp"
#include "server/certify/mesh_file.hpp"
#include "server/dataset/dataset.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/volume_options.hpp"
#include "server/store/sha256.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

struct CertifyArguments {
  std::string mesh;
  std::string volume;
  double isovalue = 0;
  std::optional<double> error;
  std::string unit = "voxel";
  std::optional<int> lattice;
  std::optional<double> min_component;
  bool any_topology = false;
  bool self_intersections = false;
  bool allow_rounding = false;
  bool is_inside_out = false;
  std::vector<double> shift;  // X,Y,Z; empty: none.
  std::vector<double> box;    // X0,Y0,Z0,X1,Y1,Z1; empty: everywhere.
  std::string outside;        // Empty: not given.
  std::optional<int> margin;
  std::string coordinates = "world";
  std::string space = "native";
  double scale = 1;
  std::uint64_t samples = CertifyOptions().samples;
  VolumeOptions source;
  int threads = 0;
  bool json = false;
  bool quiet = false;
};

// Returns the map from the mesh's coordinates to the volume's world.
Affine mesh_to_world(const CertifyArguments& arguments, const Volume& volume) {
  if (arguments.coordinates == "index") {
    if (arguments.space != "native" || !arguments.shift.empty()) {
      throw std::invalid_argument(
          "--space and --shift apply to world coordinates only, not to --coordinates index.");
    }
    return volume.index_to_world;
  }
  Affine map;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    map.columns[axis][axis] = arguments.scale;
    if (!arguments.shift.empty()) map.translation[axis] = -arguments.scale * arguments.shift[axis];
  }
  if (arguments.space == "native") return map;
  if (volume.meaning.space == WorldSpace::kUnnamed) {
    throw std::invalid_argument(
        "--space: the volume does not define the directions of its axes in a patient.");
  }
  if (volume.meaning.space == (arguments.space == "lps" ? WorldSpace::kLps : WorldSpace::kRas)) {
    return map;
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    map.columns[axis][axis] = -arguments.scale;
    map.translation[axis] = -map.translation[axis];
  }
  return map;
}

// Returns the box of --box, in coordinates that `mesh_to_world` maps.
std::optional<PlacedBox> box_of(const CertifyArguments& arguments, const Affine& mesh_to_world) {
  if (arguments.box.empty()) return std::nullopt;
  PlacedBox placed{.box = {}, .world_to_box = inverse(mesh_to_world)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    placed.box.low[axis] = arguments.box[axis];
    placed.box.high[axis] = arguments.box[axis + 3];
    if (placed.box.low[axis] < placed.box.high[axis]) continue;
    throw std::invalid_argument(
        std::string("--box: its low corner must be below its high corner along ") + "xyz"[axis] +
        ".");
  }
  return placed;
}

bool is_dataset(const std::string& place) { return place.ends_with(".mtd"); }

// Loads the samples of a dataset, to which the options of `prepare` were applied.
Volume volume_of_dataset(const CertifyArguments& arguments, CertifyOptions& options,
                         std::vector<std::string>& notices) {
  if (!arguments.outside.empty() || arguments.margin || !arguments.source.command_line().empty()) {
    throw std::invalid_argument(
        "--pad-value, --pad and the options for reading a volume are recorded in the dataset.");
  }
  const DatasetPtr dataset = open_dataset(arguments.volume);
  options.outside = dataset->info.outside;
  options.margin = dataset->info.margin;
  Volume volume = whole_volume(*dataset);
  volume.meaning = dataset->info.meaning;
  if (std::string text = rounding_text(dataset->info.name, volume.meaning); !text.empty()) {
    notices.push_back(std::move(text));
  }
  return volume;
}

// If 32-bit floats would round the samples of a file notably, returns differences from the isovalue
// instead, which they hold well where the surface is; the options then have isovalue 0.
Volume volume_of(const CertifyArguments& arguments, CertifyOptions& options, Progress& progress,
                 std::vector<std::string>& notices) {
  if (is_dataset(arguments.volume)) return volume_of_dataset(arguments, options, notices);
  options.outside = outside_from(arguments.outside.empty() ? "void" : arguments.outside);
  options.margin = arguments.margin.value_or(0);
  VolumeFileOptions source = arguments.source.parsed();
  source.choice.allow_loss = true;
  source.notice = [&](const std::string& sentence) { notices.push_back(sentence); };
  Volume volume = read_volume(arguments.volume, source);
  if (!volume.meaning.rounding.empty()) {
    notices = {"32-bit floats would round the samples (" + volume.meaning.rounding +
               "); compared are their differences from the isovalue."};
    source.choice.subtract += options.isovalue;
    if (options.outside) *options.outside -= options.isovalue;
    options.isovalue = 0;
    volume = {};  // Not both in memory.
    volume = read_volume(arguments.volume, source);
  }
  for (const std::string& sentence : notices) progress.print_above_bar(sentence);
  return volume;
}

int run_certify(const CertifyArguments& arguments) {
  (void)arguments.source.parsed();  // Also for what the mesh's reader needs.
  const ThreadLimit limit(arguments.threads);
  CertifyOptions options{.isovalue = arguments.isovalue,
                         .lattice = arguments.lattice,
                         .any_topology = arguments.any_topology,
                         .count_self_intersections = arguments.self_intersections,
                         .allow_rounding = arguments.allow_rounding,
                         .is_inside_out = arguments.is_inside_out,
                         .try_maps = arguments.coordinates == "world" && arguments.scale == 1 &&
                                     arguments.space == "native" && arguments.shift.empty(),
                         .samples = arguments.samples};
  Progress progress("certify", arguments.self_intersections ? 6 : 5,
                    arguments.quiet || arguments.json);
  options.on_stage = [&](const char* stage) { progress.begin(stage); };
  progress.begin("mesh");
  TriangleMesh mesh = read_mesh(arguments.mesh);
  if (!options.lattice) options.lattice = mesh.lattice;
  options.min_component = arguments.min_component.value_or(mesh.min_component);
  progress.begin("volume");
  std::vector<std::string> notices;
  const Volume volume = volume_of(arguments, options, progress, notices);
  std::vector<std::string> mesh_notices;
  if (arguments.coordinates == "world") {
    mesh_notices = convert_to_unit(mesh, volume.meaning.length_unit);
  }
  const Affine map = mesh_to_world(arguments, volume);
  options.within = box_of(arguments, map);
  for (Vec3& vertex : mesh.vertices) vertex = map(vertex);
  if (arguments.error) {
    const double voxel = *std::min_element(volume.spacing.begin(), volume.spacing.end());
    options.error = *arguments.error * (arguments.unit == "voxel" ? voxel : 1.0);
  }
  const Certificate certificate = certify(mesh, volume, options);
  options.isovalue = arguments.isovalue;  // Which may be 0 for differences from it.
  progress.finish();
  const CertifiedFiles files{.mesh = arguments.mesh,
                             .volume = without_password(arguments.volume),
                             .mesh_sha256 = sha256_of_file(arguments.mesh),
                             .volume_sha256 = sha256_of_file(arguments.volume),
                             .volume_notices = std::move(notices),
                             .mesh_notices = std::move(mesh_notices)};
  if (arguments.json) {
    Json report = json_of(certificate, files, options);
    report["seconds"] = progress.seconds();
    std::cout << text_of(report);
  } else if (!arguments.quiet || !certificate.passes()) {
    std::cout << text_of(certificate, files, options);
  }
  return certificate.passes() ? kOk : kCheckFailed;
}

}  // namespace

void add_certify_command(Command& program, Run& run) {
  const auto a = std::make_shared<CertifyArguments>();
  Command* command =
      program.add_subcommand("certify",
                             "Compare a mesh from any program with the full-resolution isosurface "
                             "of a volume: two-sided distance, topology, defects");
  command
      ->add_option(
          "mesh", a->mesh,
          "Mesh file: .ply, .stl, .obj, .glb (turned from y-up to z-up), .3mf, .drc or .vtp")
      ->required()
      ->type_name("MESH");
  command
      ->add_option("--volume", a->volume,
                   "Dataset (.mtd), or volume of any format (`formats` lists them)")
      ->required()
      ->type_name("FILE");
  command->add_option("--isovalue", a->isovalue, "Value of the surface")->required();
  command->add_option("--error", a->error,
                      "Largest allowed two-sided distance; default: distances are only printed");
  command
      ->add_option("--unit", a->unit,
                   "Unit of --error; voxel is the smallest spacing, world the unit of world "
                   "coordinates")
      ->one_of({"voxel", "world"})
      ->capture_default_str();
  command
      ->add_option("--lattice", a->lattice,
                   "Allow for vertices rounded to 1 / 2^R of the sample spacing; default: the R in "
                   "the mesh file, if `extract` or `fetch` wrote it")
      ->within(kMinLatticeResolution, kMaxLatticeResolution)
      ->type_name("R");
  command
      ->add_option(
          "--min-component", a->min_component,
          "Components with a shorter diagonal were removed; default: the value in the mesh file")
      ->within(0.0, 1e6)
      ->type_name("SAMPLES");
  command->add_flag("--any-topology", a->any_topology,
                    "Check the distance only, not components, holes and cracks");
  command->add_flag("--self-intersections", a->self_intersections,
                    "Count self-intersecting triangles, exactly; touching ones count");
  command->add_flag("--allow-rounding", a->allow_rounding,
                    "Also allow for the rounding of 32-bit coordinates in the mesh");
  command->add_flag("--inside-out", a->is_inside_out,
                    "Triangles of the mesh face high values instead of low ones");
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Print errors and notices about the data only");
  command->begin_group("Coordinates");
  command
      ->add_option(
          "--box", a->box,
          "Compare only distances inside this box, not the topology: of a mesh that was cut "
          "at it, or has a smaller error there; low corner first, in the mesh's coordinates")
      ->delimiter(',')
      ->expected(6)
      ->type_name("X0,Y0,Z0,X1,Y1,Z1");
  command
      ->add_option("--pad-value,--outside", a->outside,
                   "Value beyond the data, as in `prepare`, or void; default: void")
      ->type_name("VALUE");
  command
      ->add_option("--pad,--margin", a->margin,
                   "Layers of that value around the data, as in `prepare`; default: 0")
      ->within(0, 4096);
  command
      ->add_option("--coordinates", a->coordinates,
                   "Coordinates of the mesh: world, or index for samples")
      ->one_of({"world", "index"})
      ->capture_default_str();
  command
      ->add_option("--space", a->space,
                   "Axes of the mesh's world coordinates: native: those of the volume, lps: to the "
                   "patient's left, back and head, ras: to the right, front and head")
      ->one_of({"native", "lps", "ras"})
      ->capture_default_str();
  command
      ->add_option("--scale", a->scale,
                   "Factor for the mesh's world coordinates, such as 1000 for a mesh in metres and "
                   "a volume in mm; those of 3MF files are in the volume's unit before")
      ->within(1e-9, 1e9)
      ->capture_default_str();
  command
      ->add_option("--shift", a->shift,
                   "The mesh's world coordinates were shifted by this, as by --shift of `extract`")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command
      ->add_option("--samples", a->samples,
                   "Sample points of each surface for the mean and the 99th percentile; the "
                   "maximum is over all triangles")
      ->capture_default_str();
  command->begin_group("Reading the volume");
  a->source.add_to(*command);
  command->footer(
      "Examples:\n"
      "  multitetra-server certify head.ply --volume head.nrrd --isovalue 500.5 --error 0.5\n"
      "  multitetra-server certify liver.stl --volume ct/ --isovalue 120 --error 1 --unit world\n"
      "  multitetra-server certify bone.glb --volume ct.nii.gz --isovalue 300 "
      "--self-intersections --json\n"
      "Exit codes: 0 kept, 1 failed, 2 wrong usage, 3 --error or the topology is not kept.");
  command->callback([a, &run] { run = [a] { return run_certify(*a); }; });
}

}  // namespace multitetra
