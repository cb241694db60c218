#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/cli/option_sources.hpp"
#include "server/operations/log.hpp"
#include "server/operations/memory_return.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serving/repeated_work.hpp"
#include "server/programs/serving/serve_options.hpp"
#include "server/programs/serving/served_datasets.hpp"
#include "server/programs/thread_options.hpp"
#include "server/transport/server.hpp"

namespace multitetra {
namespace {

struct ServeArguments {
  ServeOptions options;
  OptionSources sources;
};

// After SIGHUP. What cannot be read changes nothing but the log.
void offer_again(Server& server, ServedDatasets& datasets) {
  try {
    const CataloguePtr catalogue = datasets.read();
    server.offer(catalogue);
    log_line(LogLevel::kInfo, "datasets read again",
             {{"datasets", static_cast<std::uint64_t>(catalogue->size())}});
  } catch (const std::exception& error) {
    log_line(LogLevel::kError, std::string("datasets stay as they are: ") + error.what(), {});
  }
}

BlockState state_of(const RemoteFiles::Counts& counts) {
  return {.memory_hits = counts.memory_hits,
          .disk_hits = counts.disk_hits,
          .fetched = counts.fetched,
          .fetched_bytes = counts.fetched_bytes,
          .retries = counts.retries,
          .failures = counts.failures,
          .evictions = counts.evictions,
          .memory_bytes = counts.memory_bytes};
}

int serve(const ServeOptions& options) {
  let_memory_go_back();
  const ThreadLimit limit(options.threads);
  start_log(log_options(options.listeners));
  make_room_for(options.listeners);
  warn_of_open_listeners(options.listeners);
  ServerOptions server_with = server_options(options);
  std::vector<MakeListener> listeners;
  if (const auto http = http_options(options.listeners)) {
    listeners.push_back(http_listener(*http, route_options(options.listeners)));
  }
  const auto cache = std::make_shared<SurfaceCache>(options.cache_bytes);
  const auto files = std::make_shared<RemoteFiles>(file_options(options));
  ServedDatasets datasets(options.datasets, cache, files);
  const CataloguePtr catalogue = datasets.read();
  if (catalogue->size() == 0) {
    throw ExitError(kNoDataset,
                    "There is no dataset that could be served; make one with: multitetra-server "
                    "prepare VOLUME -o FILE.mtd");
  }
  server_with.service.cache = cache;
  server_with.metrics = std::make_shared<PrometheusMetrics>();
  server_with.state = [cache, files] {
    const TileCache::Counts counts = cache->tiles().counts();
    return ServiceState{.cache_hits = counts.hits,
                        .cache_misses = counts.misses,
                        .cached_tiles = counts.tiles,
                        .cache_bytes = counts.bytes,
                        .blocks = state_of(files->counts())};
  };
  RepeatedWork* asked = nullptr;  // There before the server runs.
  server_with.when_reloaded = [&asked] { asked->ask(); };
  Server server(catalogue, server_with, listeners);
  // Datasets may be many, and on slow disks: they are not read by the thread that serves.
  RepeatedWork rescan([&] { offer_again(server, datasets); });
  asked = &rescan;
  for (const std::string& url : server.urls()) log_line(LogLevel::kInfo, "listening on " + url, {});
  server.run();
  log_line(LogLevel::kInfo, "stopped", {});
  return kOk;
}

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
      "and folders of datasets again; streams under way go on.\n"
      "Exit codes: 0 stopped as asked, 1 failed, 2 wrong options, 4 certificate, key or tokens "
      "cannot be\n"
      "used, 5 no dataset can be served, 7 an address cannot be listened on.");
  command->callback([a, command, &run] {
    if (!a->sources.config_file.empty()) read_config_file(*command, a->sources.config_file);
    if (a->sources.print_config) {
      run = [command] {
        std::cout << config_text(*command);
        return kOk;
      };
      return;
    }
    if (a->options.datasets.empty())
      throw UsageError("datasets", "name a dataset file or a folder of them.");
    (void)server_options(a->options);  // What is wrong with them is wrong usage.
    (void)http_options(a->options.listeners);
    run = [a] { return serve(a->options); };
  });
}

}  // namespace multitetra
