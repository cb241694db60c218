// multitetra-client: lists a server's datasets and fetches isosurfaces as mesh files.
#include <filesystem>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "client/client.hpp"
#include "client/report.hpp"
#include "common/mesh_files.hpp"
#include "common/surface_options.hpp"

namespace multitetra {
namespace {

// Exit codes, told by --help.
enum ExitCode { kOk = 0, kFailed = 1, kUsage = 2, kCheckFailed = 3 };

struct ListArguments {
  std::string server = to_string(Endpoint{.host = "127.0.0.1"});
  bool json = false;
};

struct FetchArguments {
  std::string server = to_string(Endpoint{.host = "127.0.0.1"});
  std::string dataset;
  SurfaceArguments surface;
  bool final_only = false;
  double timeout = 60;
  std::string mesh;
  std::string report;
  std::string steps_directory;
  bool json = false;
  bool quiet = false;
};

int complain(ExitCode code, const std::string& text) {
  std::cerr << "multitetra-client: " << text << "\n";
  return code;
}

int complain(const ClientError& trouble) {
  const std::string who = trouble.trouble == Trouble::kServer  ? "the server says: "
                          : trouble.trouble == Trouble::kCheck ? "a check failed: "
                                                               : "";
  return complain(trouble.trouble == Trouble::kCheck ? kCheckFailed : kFailed,
                  who + trouble.error.text);
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

int list(const ListArguments& arguments) {
  const auto server = parse_endpoint(arguments.server);
  if (!server) return complain(kUsage, server.error().text);
  auto client = Client::connect(*server, {});
  if (!client) return complain(client.error());
  const auto datasets = client->list_datasets();
  if (!datasets) return complain(datasets.error());
  std::cout << (arguments.json ? json_list(*server, *datasets) : text_list(*datasets));
  return kOk;
}

const DatasetInfo* find(const std::vector<DatasetInfo>& datasets, const std::string& name) {
  for (const DatasetInfo& info : datasets) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

std::string no_such_dataset(const std::string& name, const std::vector<DatasetInfo>& datasets) {
  std::string text = "The server has no dataset \"" + name + "\"; it has";
  for (const DatasetInfo& info : datasets) text += " \"" + info.name + "\"";
  return text + (datasets.empty() ? " none." : ".");
}

// Writes what a fetch gives as it comes.
class Output {
 public:
  Output(const FetchArguments& arguments, MeshFormat format, const DatasetInfo& info)
      : arguments_(arguments), format_(format), to_output_(output_map(arguments.surface, info)) {
    if (!arguments_.steps_directory.empty()) {
      std::filesystem::create_directories(arguments_.steps_directory);
    }
  }

  void step(const FetchedStep& fetched) const {
    if (!arguments_.quiet) std::cerr << step_line(fetched) << std::endl;
    if (arguments_.steps_directory.empty()) return;
    const std::string suffix = std::filesystem::path(arguments_.mesh).extension().string();
    const std::string name = "step_" + std::to_string(fetched.step->begin.step) + suffix;
    write_mesh(*fetched.step, std::filesystem::path(arguments_.steps_directory) / name);
  }
  void final_step(const FetchedStep& fetched) const { write_mesh(*fetched.step, arguments_.mesh); }
  // Also of a fetch that failed, with the steps that came.
  void report(const FetchReport& report) const {
    const std::string text = json_report(report);
    if (!arguments_.report.empty()) write_file(arguments_.report, text);
    if (arguments_.json) {
      std::cout << text;
    } else if (!arguments_.quiet && !report.error) {
      std::cout << checks_table(report.steps) << arguments_.mesh << " written\n";
    }
  }

 private:
  void write_mesh(const CommittedStep& step, const std::filesystem::path& path) const {
    write_file(path, mesh_file(positioned(step.mesh, to_output_), format_));
  }

  const FetchArguments& arguments_;
  MeshFormat format_;
  Affine to_output_;
};

// The step without its mesh, which a report does not need.
FetchedStep for_report(const FetchedStep& fetched) {
  auto step = std::make_shared<CommittedStep>();
  step->begin = fetched.step->begin;
  step->end = fetched.step->end;
  step->topology = fetched.step->topology;
  step->checks = fetched.step->checks;
  return {
      .step = step, .first_byte_seconds = fetched.first_byte_seconds, .seconds = fetched.seconds};
}

int fetch(const FetchArguments& arguments) {
  const auto server = parse_endpoint(arguments.server);
  if (!server) return complain(kUsage, server.error().text);
  const auto format = mesh_format_from(std::filesystem::path(arguments.mesh).extension().string());
  if (!format) {
    return complain(kUsage, "\"" + arguments.mesh +
                                "\" has no suffix of a mesh format; use .ply, .stl, .obj, .glb or "
                                ".drc.");
  }

  auto client = Client::connect(*server, {.timeout = milliseconds(arguments.timeout)});
  if (!client) return complain(client.error());
  const auto datasets = client->list_datasets();
  if (!datasets) return complain(datasets.error());
  const DatasetInfo* info = find(*datasets, arguments.dataset);
  if (info == nullptr) return complain(kFailed, no_such_dataset(arguments.dataset, *datasets));
  const auto request = request_of(arguments.surface, *info);
  if (!request) return complain(kUsage, request.error().text);
  FetchReport report{
      .server = *server,
      .open = {.dataset = info->name,
               .request = *request,
               .steps = arguments.final_only ? StepPolicy::kFinalOnly : StepPolicy::kProgressive,
               .held = {}},
      .coordinates = arguments.surface.coordinates,
      .mesh_file = {},
      .steps = {}};
  const Output output(arguments, *format, *info);
  const auto final_step = client->fetch(*info, report.open, [&](const FetchedStep& step) {
    output.step(step);
    report.steps.push_back(for_report(step));
  });
  if (!final_step) {
    report.error = final_step.error().error;
    output.report(report);
    return complain(final_step.error());
  }
  output.final_step(*final_step);
  report.mesh_file = arguments.mesh;
  output.report(report);
  return kOk;
}

const char* kExitCodes =
    "Exit codes: 0 done, 1 failed (network, server, file), 2 wrong usage, 3 a check failed.";

void add_list(CLI::App& app, ListArguments& arguments) {
  CLI::App* command = app.add_subcommand("list", "List the datasets of a server");
  command->add_option("--server", arguments.server, "Where the server listens")
      ->capture_default_str();
  command->add_flag("--json", arguments.json, "Print JSON, with histograms and affine maps");
  command->footer(std::string("Examples:\n"
                              "  multitetra-client list\n"
                              "  multitetra-client list --server tcp://example.org:7410 --json\n") +
                  kExitCodes);
}

void add_fetch(CLI::App& app, FetchArguments& a) {
  CLI::App* command = app.add_subcommand(
      "fetch", "Fetch an isosurface, coarse first, check it and write it as a mesh file");
  command->add_option("--server", a.server, "Where the server listens")->capture_default_str();
  command->add_option("--dataset", a.dataset, "Name of the dataset, as `list` tells")->required();
  add_surface_options(*command, a.surface);
  command->add_flag("--final-only", a.final_only, "No previews");
  command->add_option("--timeout", a.timeout, "Seconds of silence after which to give up")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  command->add_option("-o,--output", a.mesh, "Mesh file: .ply, .stl, .obj, .glb or .drc")
      ->required();
  command->add_option("--report", a.report,
                      "Write a JSON report of all steps to this file, also when the fetch fails");
  command->add_option("--save-steps", a.steps_directory, "Write every step to this directory");
  command->add_flag("--json", a.json, "Print the JSON report");
  command->add_flag("--quiet", a.quiet, "No line per step");
  command->footer(
      std::string("Examples:\n"
                  "  multitetra-client fetch --dataset head -o head.ply\n"
                  "  multitetra-client fetch --dataset head --isovalue 1200.5 --error 0.5 "
                  "-o bone.glb --report bone.json\n"
                  "  multitetra-client fetch --server tcp://example.org:7410 --dataset head "
                  "--error 2 --unit world --save-steps steps -o head.stl\n") +
      kExitCodes);
}

int run(int argc, char** argv) {
  CLI::App app("Fetches crack-free isosurface meshes from a Multi-Tetra server.",
               "multitetra-client");
  app.set_version_flag("--version", "multitetra-client " MULTITETRA_VERSION);
  app.require_subcommand(1);
  app.footer(std::string("Examples:\n"
                         "  multitetra-client list --server tcp://127.0.0.1:7410\n"
                         "  multitetra-client fetch --dataset head --error 1 -o head.ply\n") +
             kExitCodes);
  ListArguments list_arguments;
  FetchArguments fetch_arguments;
  add_list(app, list_arguments);
  add_fetch(app, fetch_arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kOk : kUsage;
  }
  return app.got_subcommand("list") ? list(list_arguments) : fetch(fetch_arguments);
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "multitetra-client: " << error.what() << "\n";
    return multitetra::kFailed;
  }
}
