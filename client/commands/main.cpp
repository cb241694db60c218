// multitetra-client: lists a server's datasets and fetches isosurfaces as mesh files.
#include <iostream>
#include <string>

#include "client/commands/connected_request.hpp"
#include "client/commands/estimate_command.hpp"
#include "client/commands/fetch_command.hpp"
#include "client/commands/program.hpp"
#include "client/commands/snapshot_command.hpp"
#include "client/commands/view_command.hpp"
#include "client/library/report.hpp"
#include "common/cli/command_line.hpp"
#include "common/cli/program.hpp"
#include "common/sandbox/sandbox.hpp"

namespace multitetra {
namespace {

struct ListArguments {
  ServerArguments server;
  std::string series;
  bool json = false;
};

int list(const ListArguments& arguments) {
  const ConnectedServer connected = connected_to(arguments.server);
  std::cout << (arguments.json ? json_list(connected.server, connected.datasets)
                               : text_list(connected.datasets, arguments.series));
  return kOk;
}

void add_list(Command& app, ListArguments& arguments) {
  Command* command = app.add_subcommand("list", "List the datasets of a server");
  command->add_option("series", arguments.series, "List the members of this series");
  add_server_options(*command, arguments.server);
  command->add_flag("--json", arguments.json, "Print JSON, with histograms and affine maps");
  command->footer(std::string("Examples:\n"
                              "  multitetra-client list\n"
                              "  multitetra-client list organs\n"
                              "  multitetra-client list --server tcp://example.org:7410 --json\n"
                              "  multitetra-client list --server wss://example.org "
                              "--token-file token\n") +
                  kExitCodes);
}

int run(int argc, char** argv) {
  Command app("Fetches watertight isosurface meshes from a Multi-Tetra server.",
              "multitetra-client");
  add_program_flags(app);
  app.require_subcommand();
  app.footer(std::string("Examples:\n"
                         "  multitetra-client list --server tcp://127.0.0.1:7410\n"
                         "  multitetra-client fetch --dataset head --error 1 -o head.ply\n"
                         "  multitetra-client snapshot --dataset head -o head.png\n"
                         "Each command has its own --help.\n") +
             kExitCodes);
  ListArguments list_arguments;
  EstimateArguments estimate_arguments;
  FetchArguments fetch_arguments;
  SnapshotArguments snapshot_arguments;
  ViewArguments view_arguments;
  add_list(app, list_arguments);
  add_estimate(app, estimate_arguments);
  add_fetch(app, fetch_arguments);
  add_snapshot(app, snapshot_arguments);
  add_view(app, view_arguments);
  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  if (app.got_subcommand("list")) return list(list_arguments);
  if (app.got_subcommand("estimate")) return estimate(estimate_arguments);
  if (app.got_subcommand("snapshot")) return snapshot(snapshot_arguments);
  if (app.got_subcommand("view")) return view(view_arguments);
  return fetch(fetch_arguments);
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  multitetra::enter_sandbox_if_asked(argc, argv);
  return multitetra::run_program(multitetra::kProgram, [&] { return multitetra::run(argc, argv); });
}
