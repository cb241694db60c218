#include "client/commands/fetch_command.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "client/commands/colored_mesh.hpp"
#include "client/commands/fetch_parts.hpp"
#include "client/commands/program.hpp"
#include "client/library/client.hpp"
#include "client/library/report.hpp"
#include "client/library/tile_disk_cache.hpp"
#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "common/cli/surface_files.hpp"
#include "common/cli/terminal.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {
namespace {

void require_outputs_of(const FetchArguments& arguments, const std::vector<FetchPart>& parts) {
  std::vector<NamedFile> outputs;
  for (const FetchPart& part : parts) {
    const bool is_shared = !outputs.empty() && outputs.back().file == part.mesh_file;
    if (!is_shared) outputs.push_back({"--output", part.mesh_file});
  }
  outputs.push_back({"--report", arguments.report});
  require_outputs(outputs, {{"--threshold-grid", arguments.order.surface.threshold_grid},
                            {"--token-file", arguments.order.server.token_file},
                            {"--ca", arguments.order.server.ca_file}});
}

// Writes steps, final meshes and reports.
class Output {
 public:
  Output(const FetchArguments& arguments, MeshFormat format)
      : arguments_(arguments), format_(format) {}

  void step(const FetchedStep& fetched, const FetchPart& part, const DatasetInfo& info) const {
    if (!arguments_.order.quiet) std::cerr << step_line(fetched, info) << std::endl;
    if (part.steps_directory.empty()) return;
    const std::string suffix = std::filesystem::path(part.mesh_file).extension().string();
    const std::string name = "step_" + std::to_string(fetched.step->begin.step) + suffix;
    const OutputSurface surface = surface_of(fetched, info);
    const NamedMesh file = {
        .file = part.steps_directory / name, .name = surface_name(info), .surface = &surface};
    static_cast<void>(write_surfaces({&file, 1}, format_, codec()));
  }
  // Returns the step's mesh as written to files.
  [[nodiscard]] OutputSurface surface_of(const FetchedStep& fetched,
                                         const DatasetInfo& info) const {
    OutputSurface surface = output_surface(fetched.step->mesh, arguments_.order.surface, info);
    paint(surface.mesh, fetched.step->begin.scalars, arguments_.order.surface.query.colors);
    return surface;
  }
  [[nodiscard]] std::vector<WrittenMesh> final_steps(std::span<const NamedMesh> files,
                                                     bool counts_self_intersections) const {
    return write_surfaces(files, format_, codec(), counts_self_intersections);
  }
  // Also called for a failed fetch, with the steps received.
  void report(std::span<const FetchReport> reports, bool are_several) const {
    const std::string text = are_several ? json_report(reports) : json_report(reports[0]);
    if (!arguments_.report.empty()) write_file(arguments_.report, text);
    if (arguments_.json) {
      std::cout << text;
    } else if (!arguments_.order.quiet) {
      std::string names;
      std::string written;  // A GLB of several surfaces is named once.
      for (const FetchReport& report : reports) {
        if (report.error) continue;
        std::cout << checks_table(report.steps);
        if (!report.mesh_file.empty() && report.mesh_file != written) {
          written = report.mesh_file;
          names += written + " written\n";
        }
      }
      std::cout << names;
    }
  }

 private:
  [[nodiscard]] MeshCodec codec() const { return arguments_.order.surface.query.codec; }

  const FetchArguments& arguments_;
  MeshFormat format_;
};

RetryOptions retry_options(const FetchArguments& arguments) {
  return {.most = arguments.retries,
          .deadline = deadline_of(arguments.order.server),
          .on_retry = [quiet = arguments.order.quiet](const Retry& retry) {
            if (quiet) return;
            std::cerr << printable(retry.reason.text) << " Retrying in "
                      << human_seconds(std::chrono::duration<double>(retry.wait).count()) << " ("
                      << retry.number << ")." << std::endl;
          }};
}

// Tiles of earlier fetches and of this one, stored in the folder of --resume if given.
class CachedTileRecords {
 public:
  explicit CachedTileRecords(const FetchArguments& arguments)
      : arguments_(arguments), memory_({.tiles = limits_.tiles, .triangles = limits_.triangles}) {
    if (arguments.resume_directory.empty()) return;
    folder_.emplace(arguments.resume_directory);
    const auto loaded = folder_->load(memory_, limits_.triangles);
    if (arguments.order.quiet) return;
    std::cerr << human_count(loaded.tiles) << " tiles are in " << arguments.resume_directory;
    if (loaded.damaged > 0) {
      std::cerr << ", " << human_count(loaded.damaged) << " damaged files are ignored";
    }
    std::cerr << std::endl;
  }

  // Counts retries and received tiles in the report. Both objects must outlive the options.
  [[nodiscard]] FetchOptions fetch_options(FetchReport& report) {
    report.tiles_held = memory_.size();
    RetryOptions retries = retry_options(arguments_);
    retries.on_retry = [&report, print_retry = std::move(retries.on_retry)](const Retry& retry) {
      ++report.reconnections;
      print_retry(retry);
    };
    return {.retries = std::move(retries),
            .tiles = &memory_,
            .on_tile = [this, &report](const TileSummary& tile, const StepBegin& step,
                                       const std::string& payload) {
              ++report.received.tiles;
              report.received.payload_bytes += payload.size();
              if (!folder_ || step.shell) return;  // The final mesh has no shell tiles.
              folder_->keep(tile, step.request.lattice_resolution, step.request.normal_bits,
                            payload);
            }};
  }

 private:
  const FetchArguments& arguments_;
  AssemblerLimits limits_;
  DecodedTileCache memory_;
  std::optional<TileDiskCache> folder_;
};

// Copies the step without its mesh, which a report does not need.
FetchedStep for_report(const FetchedStep& fetched) {
  auto step = std::make_shared<CommittedStep>();
  step->begin = fetched.step->begin;
  step->end = fetched.step->end;
  step->topology = fetched.step->topology;
  step->checks = fetched.step->checks;
  return {
      .step = step, .first_byte_seconds = fetched.first_byte_seconds, .seconds = fetched.seconds};
}

// Fetches and checks one surface.
ClientResult<OutputSurface> fetch_part(const FetchArguments& arguments, const FetchPart& part,
                                       Client& client, DatasetRequest& surface,
                                       const Output& output, CachedTileRecords& kept,
                                       FetchReport& report) {
  const DatasetInfo& info = surface.info;
  const auto final_step = client.fetch(
      info, report.open,
      [&](const FetchedStep& step) {
        output.step(step, part, info);
        report.steps.push_back(for_report(step));
      },
      kept.fetch_options(report));
  if (!final_step) return tl::unexpected(final_step.error());
  if (final_step->step->topology.triangles == 0) {
    surface.notices.add(empty_surface_text(report.open.request, info));
  }
  surface.notices.add(request_notices(final_step->step->begin.request, info));
  const LatticeMesh& mesh = final_step->step->mesh;
  report.distance_bound = mesh_distance_bound(final_step->step->begin, info);
  const bool has_report = arguments.json || !arguments.report.empty();
  if (has_report) {
    report.open_reason = open_reason(info);
    report.measures =
        measures_from(mesh, arguments.order.surface.query.min_component, grid_to_world(info));
    surface.notices.add(volume_notice(*report.measures, report.distance_bound));
  }
  surface.notices.add(missing_values_notice(mesh.scalars, arguments.order.surface.query.color_by));
  OutputSurface written = output.surface_of(*final_step, info);
  const std::string left_out = removed_text(written);
  if (!left_out.empty()) surface.notices.add("The file has " + left_out + ".");
  const std::string accuracy = accuracy_text(*final_step->step);
  if (!accuracy.empty() && !arguments.order.quiet) std::cerr << accuracy << std::endl;
  return written;
}

// All surfaces of an order, and their reports.
class Fetch {
 public:
  Fetch(const FetchArguments& arguments, MeshFormat format, ConnectedRequests connected,
        std::vector<FetchPart> parts)
      : arguments_(arguments),
        format_(format),
        connected_(std::move(connected)),
        parts_(std::move(parts)),
        output_(arguments, format),
        kept_(arguments) {}

  // Fetches and writes all surfaces and prints the report. Throws ExitError.
  void run() {
    for (const FetchPart& part : parts_) {
      if (!part.steps_directory.empty()) std::filesystem::create_directories(part.steps_directory);
      fetch(part);
    }
    require_surfaces();
    const std::vector<NamedMesh> files = files_to_write();
    const bool counts_self_intersections =
        (arguments_.json || !arguments_.report.empty() || format_ == MeshFormat::kStl) &&
        std::any_of(reports_.begin(), reports_.end(), [](const FetchReport& report) {
          return simplification_bound(report.steps.back().step->begin) > 0;
        });
    const std::vector<WrittenMesh> written = output_.final_steps(files, counts_self_intersections);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (!files[i].file.empty()) complete_report(i, written[i]);
    }
    print_reports();
  }

 private:
  void fetch(const FetchPart& part) {
    DatasetRequest& surface = connected_.datasets[part.dataset];
    reports_.push_back(begun_report(part, surface));
    auto fetched =
        fetch_part(arguments_, part, connected_.client, surface, output_, kept_, reports_.back());
    if (!fetched) {
      reports_.back().error = fetched.error().error;
      print_reports();
      exit_with(fetched.error());
    }
    surfaces_.push_back(*std::move(fetched));
    names_.push_back(name_of(part, surface.info, connected_.is_series));
    reports_.back().notices = surface.notices.texts();
  }

  [[nodiscard]] FetchReport begun_report(const FetchPart& part,
                                         const DatasetRequest& surface) const {
    const bool has_previews = arguments_.previews || !arguments_.steps_directory.empty();
    return {.server = connected_.server,
            .open = {.dataset = surface.info.name,
                     .request = surface.requests[part.request],
                     .steps = has_previews ? StepPolicy::kProgressive : StepPolicy::kFinalOnly,
                     .cached_tile_digests = {},
                     .scalars = surface.scalars},
            .notices = surface.notices.texts(),
            .coordinates = std::string(name(arguments_.order.surface.query.coordinates)),
            .shift = arguments_.order.surface.shift,
            .mesh_file = {},
            .steps = {}};
  }

  // Returns the files of all parts. Unless empty ones are allowed, those without any triangle have
  // no name, with a notice at the first of them.
  std::vector<NamedMesh> files_to_write() {
    std::vector<NamedMesh> files;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      files.push_back({.file = parts_[i].mesh_file, .name = names_[i], .surface = &surfaces_[i]});
    }
    if (arguments_.order.surface.allow_empty) return files;
    const std::vector<std::string> notice = leave_out_empty_files(files);
    const auto first = std::find_if(files.begin(), files.end(),
                                    [](const NamedMesh& one) { return one.file.empty(); });
    if (first == files.end()) return files;
    const auto part = static_cast<std::size_t>(first - files.begin());
    Notices& notices = connected_.datasets[parts_[part].dataset].notices;
    notices.add(notice);
    reports_[part].notices = notices.texts();
    return files;
  }

  // Some labels or times of a series may be empty.
  void require_surfaces() const {
    const bool has_any = std::any_of(surfaces_.begin(), surfaces_.end(),
                                     [](const auto& surface) { return surface.components > 0; });
    if (arguments_.order.surface.allow_empty || (connected_.is_series && has_any)) return;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (surfaces_[i].components > 0) continue;
      print_reports();
      throw ExitError(kEmptySurface, not_written_text(parts_[i].mesh_file));
    }
  }

  void complete_report(std::size_t i, const WrittenMesh& written) {
    FetchReport& report = reports_[i];
    report.components_written = surfaces_[i].components;
    report.triangles_written = surfaces_[i].mesh.triangles.size();
    report.mesh_file = parts_[i].mesh_file;
    report.written = written;
    if (const auto& crossing = written.self_intersections) {
      report.self_intersecting_triangles = crossing->triangles;
    }
    DatasetRequest& surface = connected_.datasets[parts_[i].dataset];
    if (format_ == MeshFormat::kStl) {
      surface.notices.add(printing_notices(parts_[i].mesh_file, written, surface.info));
    }
    // One file of several surfaces has the whole budget.
    const std::uint64_t max_bytes = format_ == MeshFormat::kGlb
                                        ? arguments_.order.surface.query.request.max_bytes
                                        : surface.requests[parts_[i].request].max_bytes;
    surface.notices.add(larger_file_notice(parts_[i].mesh_file, max_bytes));
    reports_[i].notices = surface.notices.texts();
  }

  void print_reports() const { output_.report(reports_, /*are_several=*/parts_.size() > 1); }

  const FetchArguments& arguments_;
  const MeshFormat format_;
  ConnectedRequests connected_;
  const std::vector<FetchPart> parts_;
  const Output output_;
  CachedTileRecords kept_;
  std::vector<FetchReport> reports_;  // One per part that was begun; the others per fetched part.
  std::vector<OutputSurface> surfaces_;
  std::vector<SurfaceName> names_;
};

}  // namespace

int fetch(const FetchArguments& arguments) {
  const auto format = mesh_format_from(std::filesystem::path(arguments.mesh).extension().string());
  if (!format) {
    throw ExitError(kUsage, "\"" + arguments.mesh +
                                "\" has no mesh file suffix; use .ply, .stl, .obj, .glb, "
                                ".drc or .vtp.");
  }
  require_codec(arguments.order.surface, *format == MeshFormat::kGlb);
  std::vector<FetchPart> parts = parts_of(arguments, *format);
  require_outputs_of(arguments, parts);
  ConnectedRequests connected = ordered_datasets(arguments.order, retry_options(arguments));
  share_budget(connected);
  if (connected.is_series) {
    parts = parts_of(arguments, *format, connected.datasets);
    require_outputs_of(arguments, parts);
  }
  Fetch(arguments, *format, std::move(connected), std::move(parts)).run();
  return kOk;
}

void add_fetch(Command& app, FetchArguments& a) {
  Command* command =
      app.add_subcommand("fetch", "Fetch an isosurface, check it and write it as a mesh file");
  add_order_options(
      *command, a.order,
      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize, FieldGroup::kColors});
  add_output_options(*command, a.order.surface);
  command
      ->add_option(
          "-o,--output", a.mesh,
          "Mesh file: .ply, .stl, .obj, .glb, .drc or .vtp. Several surfaces of one time are "
          "parts of one .glb; otherwise one file each, with the dataset or isovalue in its "
          "name")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--resume", a.resume_directory,
                   "Keep tiles in this folder and fetch only missing ones; an interrupted run "
                   "continues where it stopped")
      ->type_name("DIR");
  command->add_flag("--quiet", a.order.quiet, "Print errors only");
  command->begin_group("Transfer and reports");
  command->add_flag(
      "--previews", a.previews,
      "Fetch and check coarser surfaces first, as a viewer does; implied by --save-steps");
  command
      ->add_option(
          "--retries", a.retries,
          "Consecutive retries when the server cannot be reached or the connection is lost")
      ->within(0, 1'000'000)
      ->capture_default_str();
  command
      ->add_option("--report", a.report,
                   "Write a JSON report of all steps to this file, also when the fetch fails")
      ->type_name("FILE");
  command->add_option("--save-steps", a.steps_directory, "Write every step to this directory")
      ->type_name("DIR");
  command->add_flag("--json", a.json, "Print the JSON report");
  command->footer(
      std::string(
          "Examples:\n"
          "  multitetra-client fetch --dataset head -o head.ply\n"
          "  multitetra-client fetch --dataset head --error 0 --resume head.tiles "
          "-o head.ply\n"
          "  multitetra-client fetch --dataset head --isovalue 1200.5 --error 0.5 "
          "-o bone.glb --report bone.json\n"
          "  multitetra-client fetch --dataset head --isovalue 500.5,1200.5 "
          "-o skin_and_bone.glb\n"
          "  multitetra-client fetch --dataset organs -o organs.glb    (a series: all labels)\n"
          "  multitetra-client fetch --dataset density --color-by temperature --colors "
          "coolwarm -o density.glb\n"
          "  multitetra-client fetch --server wss://example.org --token-file token "
          "--dataset head -o head.ply\n"
          "  multitetra-client fetch --server tcp://example.org:7410 --dataset head "
          "--error 2 --unit world --save-steps steps -o head.stl\n") +
      kExitCodes);
}

}  // namespace multitetra
