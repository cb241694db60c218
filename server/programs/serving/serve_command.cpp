#include <unistd.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/in_parallel.hpp"
#include "common/cli/option_sources.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serving/dataset_server.hpp"
#include "server/programs/serving/serve_options.hpp"
#include "server/programs/view/viewed_volumes.hpp"
#include "server/programs/view/volume_queue.hpp"
#include "server/programs/volume_options.hpp"

namespace multitetra {
namespace {

struct ServeArguments {
  ServeOptions options;
  OptionSources sources;
  bool requires_isolation = false;
};

// Prepares volumes into a cache while it serves.
int serve(ServeOptions options, bool requires_isolation) {
  std::vector<std::string> volumes;
  std::erase_if(options.datasets, [&](const std::string& input) {
    if (!is_unprepared(input)) return false;
    volumes.push_back(input);
    return true;
  });
  if (volumes.empty()) return serve_until_stopped(options);
  const ThreadLimit limit(options.threads);
  VolumeQueueOptions reading{.command = "serve",
                             .cache_folder = options.volume_cache,
                             .quiet = ::isatty(STDERR_FILENO) == 0};
  reading.volume.requires_isolation = requires_isolation;
  std::optional<VolumeQueue> queue;
  try {
    queue.emplace(volumes, std::move(reading));
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
  if (queue->begin()) options.readings = queue->readings();
  const std::vector<std::string>& prepared = queue->datasets();
  options.datasets.insert(options.datasets.end(), prepared.begin(), prepared.end());
  return serve_until_stopped(options, [&](const OpenServer& server) {
    return queue->run_behind(server.read_again, server.stop_if_empty);
  });
}

}  // namespace

void add_serve_command(Command& program, Run& run) {
  const auto a = std::make_shared<ServeArguments>();
  Command* command = program.add_subcommand(
      "serve", "Serve volumes and datasets to clients until stopped (Ctrl-C)");
  add_serve_options(*command, a->options);
  add_isolation_option(*command, a->requires_isolation);
  add_option_sources(*command, a->sources);
  command->footer(
      "Examples:\n"
      "  multitetra-server serve head.nrrd\n"
      "  multitetra-server serve head.mtd\n"
      "  multitetra-server serve datasets/ --tcp 0.0.0.0:7410 --tls-cert server.pem --tls-key "
      "server.key --tokens tokens\n"
      "  multitetra-server serve https://store.example/volumes/head.mtd --cache-dir "
      "/var/cache/multitetra\n"
      "Signals: SIGTERM and SIGINT drain, then stop; SIGHUP reloads certificate, tokens\n"
      "and folders of datasets; running streams continue.\n"
      "Exit codes: 0 stopped by request, 1 failed, 2 wrong options, 4 certificate, key or tokens "
      "cannot be\n"
      "used, 5 no dataset can be served, 7 cannot listen on an address.");
  command->callback([a, command, &run] {
    if (!a->sources.config_file.empty()) read_config_file(*command, a->sources.config_file);
    if (a->sources.print_config) {
      run = [command] {
        std::cout << config_text(*command, {"datasets", "tls-cert", "tls-key", "tokens", "viewer",
                                            "cache-dir", "volume-cache"});
        return kOk;
      };
      return;
    }
    if (a->options.datasets.empty())
      throw UsageError("datasets", "give a volume, a dataset or a folder of datasets.");
    (void)server_options(a->options);  // Throws for invalid options.
    (void)http_options(a->options.listeners);
    run = [a] { return serve(a->options, a->requires_isolation); };
  });
}

}  // namespace multitetra
