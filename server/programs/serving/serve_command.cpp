#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/cli/option_sources.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serving/dataset_server.hpp"
#include "server/programs/serving/serve_options.hpp"

namespace multitetra {
namespace {

struct ServeArguments {
  ServeOptions options;
  OptionSources sources;
};

}  // namespace

void add_serve_command(Command& program, Run& run) {
  const auto a = std::make_shared<ServeArguments>();
  Command* command =
      program.add_subcommand("serve", "Serve datasets to clients until stopped (Ctrl-C)");
  add_serve_options(*command, a->options);
  add_option_sources(*command, a->sources);
  command->footer(
      "Examples:\n"
      "  multitetra-server serve head.mtd\n"
      "  multitetra-server serve datasets/ --tcp 0.0.0.0:7410 --tls-cert server.pem --tls-key "
      "server.key --tokens tokens\n"
      "  multitetra-server serve https://store.example/volumes/head.mtd --cache-dir "
      "/var/cache/multitetra\n"
      "Signals: SIGTERM and SIGINT drain, then stop; SIGHUP reads certificate, tokens\n"
      "and folders of datasets again; running streams continue.\n"
      "Exit codes: 0 stopped by request, 1 failed, 2 wrong options, 4 certificate, key or tokens "
      "cannot be\n"
      "used, 5 no dataset can be served, 7 an address cannot be listened on.");
  command->callback([a, command, &run] {
    if (!a->sources.config_file.empty()) read_config_file(*command, a->sources.config_file);
    if (a->sources.print_config) {
      run = [command] {
        std::cout << config_text(
            *command, {"datasets", "tls-cert", "tls-key", "tokens", "viewer", "cache-dir"});
        return kOk;
      };
      return;
    }
    if (a->options.datasets.empty())
      throw UsageError("datasets", "name a dataset file or a folder of them.");
    (void)server_options(a->options);  // Throws for invalid options.
    (void)http_options(a->options.listeners);
    run = [a] { return serve_until_stopped(a->options); };
  });
}

}  // namespace multitetra
