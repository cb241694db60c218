// multitetra-client: lists a server's datasets and fetches isosurfaces as mesh files.
#include <iostream>
#include <memory>
#include <string>

#include "client/commands/commands.hpp"
#include "client/commands/connected_request.hpp"
#include "client/commands/program.hpp"
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

void add_list(Command& program, Run& run) {
  const auto a = std::make_shared<ListArguments>();
  Command* command = program.add_subcommand("list", "List the datasets of a server");
  command->add_option("series", a->series, "List the members of this series");
  add_server_options(*command, a->server);
  command->add_flag("--json", a->json, "Print JSON, with histograms and affine maps");
  command->footer(std::string("Examples:\n"
                              "  multitetra-client list\n"
                              "  multitetra-client list organs\n"
                              "  multitetra-client list --server tcp://example.org:7410 --json\n"
                              "  multitetra-client list --server wss://example.org "
                              "--token-file token\n") +
                  kExitCodes);
  command->callback([a, &run] { run = [a] { return list(*a); }; });
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
  Run command;
  add_list(app, command);
  add_estimate(app, command);
  add_fetch(app, command);
  add_snapshot(app, command);
  add_view(app, command);
  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  return command();
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  multitetra::enter_sandbox_if_asked(argc, argv);
  return multitetra::run_program(multitetra::kProgram, [&] { return multitetra::run(argc, argv); });
}
