// multitetra-client: lists a server's datasets and fetches isosurfaces as mesh files.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "client/client.hpp"
#include "client/estimate_command.hpp"
#include "client/fetch_command.hpp"
#include "client/program.hpp"
#include "client/report.hpp"
#include "client/server_options.hpp"
#include "client/view_command.hpp"

namespace multitetra {
namespace {

struct ListArguments {
  ServerArguments server;
  bool json = false;
};

int list(const ListArguments& arguments) {
  const auto access = access_of(arguments.server);
  if (!access) return complain(kUsage, access.error().text);
  auto client = Client::connect(access->server, access->options);
  if (!client) return complain(client.error());
  const auto datasets = client->list_datasets();
  if (!datasets) return complain(datasets.error());
  std::cout << (arguments.json ? json_list(access->server, *datasets) : text_list(*datasets));
  return kOk;
}

void add_list(CLI::App& app, ListArguments& arguments) {
  CLI::App* command = app.add_subcommand("list", "List the datasets of a server");
  add_server_options(*command, arguments.server);
  command->add_flag("--json", arguments.json, "Print JSON, with histograms and affine maps");
  command->footer(std::string("Examples:\n"
                              "  multitetra-client list\n"
                              "  multitetra-client list --server tcp://example.org:7410 --json\n"
                              "  multitetra-client list --server wss://example.org "
                              "--token-file token\n") +
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
  EstimateArguments estimate_arguments;
  FetchArguments fetch_arguments;
  ViewArguments view_arguments;
  add_list(app, list_arguments);
  add_estimate(app, estimate_arguments);
  add_fetch(app, fetch_arguments);
  add_view(app, view_arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kOk : kUsage;
  }
  if (app.got_subcommand("list")) return list(list_arguments);
  if (app.got_subcommand("estimate")) return estimate(estimate_arguments);
  if (app.got_subcommand("view")) return view(view_arguments);
  return fetch(fetch_arguments);
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
