// `multitetra-client fetch`: fetches an isosurface, checks it and writes a mesh file.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/commands/fetch_parts.hpp"
#include "client/commands/program.hpp"
#include "client/library/client.hpp"
#include "client/library/report.hpp"
#include "client/library/tile_disk_cache.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/surface_output.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"

namespace multitetra {
namespace {

void require_outputs_of(const FetchArguments& arguments, const std::vector<FetchPart>& parts) {
  std::vector<std::string> files;
  for (const FetchPart& part : parts) files.push_back(part.mesh_file);
  require_outputs_of(std::move(files), arguments.output,
                     {{"--threshold-grid", arguments.order.surface.threshold_grid},
                      {"--token-file", arguments.order.server.token_file},
                      {"--ca", arguments.order.server.ca_file}});
}

// Prints and writes one step.
void put_step(const FetchedStep& fetched, const FetchArguments& arguments, const FetchPart& part,
              const DatasetInfo& info) {
  if (!arguments.output.quiet) std::cerr << step_line(fetched, info) << std::endl;
  if (part.steps_directory.empty()) return;
  const SurfaceArguments& options = arguments.order.surface;
  OutputSurface surface = output_surface(fetched.step->mesh, options, info);
  paint(surface.mesh, fetched.step->begin.scalars, options.query.colors);
  const std::string suffix = std::filesystem::path(part.mesh_file).extension().string();
  const std::string name = "step_" + std::to_string(fetched.step->begin.step) + suffix;
  write_surface(part.steps_directory / name, {surface_name(info), &surface}, options.query.codec);
}

RetryOptions retry_options(const FetchArguments& arguments) {
  return {.most = arguments.retries,
          .deadline = deadline_of(arguments.order.server),
          .on_retry = [quiet = arguments.output.quiet](const Retry& retry) {
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
    if (arguments.output.quiet) return;
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
              if (!step.shell) keep(tile, step.request, payload);  // The final mesh has no others.
            }};
  }

 private:
  // A folder that cannot be written does not keep the surface from being fetched.
  void keep(const TileSummary& tile, const IsosurfaceRequest& request, const std::string& payload) {
    if (!folder_) return;
    try {
      folder_->keep(tile, request.lattice_resolution, request.normal_bits, payload);
    } catch (const std::system_error& problem) {
      std::cerr << "Tiles cannot be kept for --resume: " << problem.what() << std::endl;
      folder_.reset();
    }
  }

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

// All surfaces of an order, and their reports.
class Fetch {
 public:
  Fetch(const FetchArguments& arguments, ConnectedRequests connected, std::vector<FetchPart> parts)
      : arguments_(arguments),
        connected_(std::move(connected)),
        parts_(std::move(parts)),
        kept_(arguments) {}

  // Fetches and writes all surfaces and prints the report. Throws ExitError.
  void run() {
    for (const FetchPart& part : parts_) {
      if (!part.steps_directory.empty()) std::filesystem::create_directories(part.steps_directory);
      fetch(part);
    }
    const SurfaceArguments& options = arguments_.order.surface;
    // Some labels or times of a series may be empty.
    if (const OutputPart* const empty =
            forbidden_empty(outputs_, options, /*may_lack_some=*/connected_.is_series)) {
      print_reports();
      throw ExitError(kEmptySurface, not_written_text(empty->file));
    }
    write_files(outputs_, options, arguments_.output, /*counts_self_intersections=*/false);
    print_reports();
  }

 private:
  void fetch(const FetchPart& part) {
    DatasetRequest& surface = connected_.datasets[part.dataset];
    reports_.push_back(begun_report(surface, part));
    FetchReport& report = reports_.back();
    outputs_.push_back({.info = &surface.info,
                        .notices = &surface.notices,
                        .name = name_of(part, surface.info, connected_.is_series),
                        .file = part.mesh_file,
                        .max_bytes = max_bytes_of(surface, part)});
    const auto final_step = connected_.client.fetch(
        surface.info, report.open,
        [&](const FetchedStep& step) {
          put_step(step, arguments_, part, surface.info);
          report.steps.push_back(for_report(step));
        },
        kept_.fetch_options(report));
    if (!final_step) {
      report.error = final_step.error().error;
      print_reports();
      exit_with(final_step.error());
    }
    finish(outputs_.back(), *final_step->step, surface.scalars, arguments_.order.surface,
           arguments_.output);
  }

  [[nodiscard]] FetchReport begun_report(const DatasetRequest& surface,
                                         const FetchPart& part) const {
    const bool has_previews = arguments_.previews || !arguments_.steps_directory.empty();
    return {.server = connected_.server,
            .open = {.dataset = surface.info.name,
                     .request = surface.requests[part.request],
                     .steps = has_previews ? StepPolicy::kProgressive : StepPolicy::kFinalOnly,
                     .cached_tile_digests = {},
                     .scalars = surface.scalars},
            .steps = {}};
  }

  // One file of several surfaces has the whole budget.
  [[nodiscard]] std::uint64_t max_bytes_of(const DatasetRequest& surface,
                                           const FetchPart& part) const {
    const bool is_shared = holds_several(mesh_format_of(part.mesh_file, arguments_.order.surface));
    return is_shared ? arguments_.order.surface.query.request.max_bytes
                     : surface.requests[part.request].max_bytes;
  }

  void print_reports() {
    std::vector<Json> reports;
    std::string names;
    std::string written;  // A GLB of several surfaces is named once.
    const bool prints_tables = !arguments_.output.json && !arguments_.output.quiet;
    for (std::size_t i = 0; i < reports_.size(); ++i) {
      FetchReport& report = reports_[i];
      report.surface = outputs_[i].report;
      report.surface.notices = outputs_[i].notices->texts();
      reports.push_back(json_of(report));
      if (!prints_tables || report.error) continue;
      std::cout << checks_table(report.steps);
      const std::string& file = report.surface.mesh_file;
      if (file.empty() || file == written) continue;
      written = file;
      names += written + " written\n";
    }
    std::cout << names;
    write_report(std::move(reports), /*are_several=*/parts_.size() > 1, arguments_.output);
  }

  const FetchArguments& arguments_;
  ConnectedRequests connected_;
  const std::vector<FetchPart> parts_;
  CachedTileRecords kept_;
  // One per part that was begun.
  std::vector<FetchReport> reports_;
  std::vector<OutputPart> outputs_;
};

int fetch(const FetchArguments& arguments) {
  const MeshFormat format = mesh_format_of(arguments.output.file, arguments.order.surface);
  std::vector<FetchPart> parts = parts_of(arguments, format);
  require_outputs_of(arguments, parts);
  SurfaceOrder order = arguments.order;
  order.quiet = arguments.output.quiet;
  ConnectedRequests connected = ordered_datasets(order, retry_options(arguments));
  share_budget(connected);
  if (connected.is_series) {
    parts = parts_of(arguments, format, connected.datasets);
    require_outputs_of(arguments, parts);
  }
  Fetch(arguments, std::move(connected), std::move(parts)).run();
  return kOk;
}

}  // namespace

void add_fetch(Command& program, Run& run) {
  const auto a = std::make_shared<FetchArguments>();
  Command* command =
      program.add_subcommand("fetch", "Fetch an isosurface, check it and write it as a mesh file");
  add_order_options(
      *command, a->order,
      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize, FieldGroup::kColors});
  add_output_options(*command, a->order.surface, a->output);
  command
      ->add_option("--resume", a->resume_directory,
                   "Keep tiles in this folder and fetch only missing ones; an interrupted run "
                   "continues where it stopped")
      ->type_name("DIR");
  command->begin_group("Transfer");
  command->add_flag(
      "--previews", a->previews,
      "Fetch and check coarser surfaces first, as a viewer does; implied by --save-steps");
  command
      ->add_option(
          "--retries", a->retries,
          "Consecutive retries when the server cannot be reached or the connection is lost")
      ->within(0, 1'000'000)
      ->capture_default_str();
  command->add_option("--save-steps", a->steps_directory, "Write every step to this directory")
      ->type_name("DIR");
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
  command->callback([a, &run] { run = [a] { return fetch(*a); }; });
}

}  // namespace multitetra
