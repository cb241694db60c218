#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/cli/option_sources.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/http/http_options.hpp"
#include "server/operations/log.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serve_options.hpp"
#include "server/programs/thread_options.hpp"
#include "server/stream/step_source.hpp"
#include "server/transport/server.hpp"

namespace multitetra {
namespace {

struct ServeArguments {
  ServeOptions options;
  OptionSources sources;
};

// The files themselves, and those named *.mtd in directories, each once, in order.
std::vector<std::filesystem::path> dataset_files(const std::vector<std::string>& inputs) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path input : inputs) {
    if (!std::filesystem::is_directory(input)) {
      files.push_back(input);
      continue;
    }
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(input)) {
      if (entry.path().extension() == ".mtd") found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::string size_text(const DatasetInfo& info) {
  return std::to_string(info.dims[0]) + " x " + std::to_string(info.dims[1]) + " x " +
         std::to_string(info.dims[2]) + " " + std::string(name(info.type));
}

// A dataset that cannot be served is told and left out.
CataloguePtr open_all(const std::vector<std::filesystem::path>& files,
                      const std::shared_ptr<StepCache>& cache) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  const auto pool = std::make_shared<CubeMemoryPool>();
  for (const std::filesystem::path& file : files) {
    const std::string path = file.string();
    try {
      const DatasetPtr dataset = open_dataset(file);
      catalogue->add(std::make_shared<ExtractedSteps>(
          std::make_shared<SurfaceExtractor>(dataset, pool), cache));
      const std::string size = size_text(dataset->info);
      log_line(LogLevel::kInfo, "serving",
               {{"dataset", dataset->info.name}, {"file", path}, {"size", size}});
    } catch (const std::exception& error) {
      log_line(LogLevel::kError, std::string("left out: ") + error.what(), {{"file", path}});
    }
  }
  if (catalogue->size() == 0) {
    throw ExitError(kNoDataset,
                    "There is no dataset that could be served; make one with: multitetra-server "
                    "prepare VOLUME -o FILE.mtd");
  }
  return catalogue;
}

std::vector<MakeListener> more_listeners(std::optional<HttpOptions> http,
                                         const std::shared_ptr<StepCache>& cache) {
  if (!http) return {};
  http->hooks.find_tile = [cache](const ContentDigest& digest) {
    return cache->tiles().find_plain(digest);
  };
  return {http_listener(*std::move(http))};
}

int serve(const ServeOptions& options) {
  const ThreadLimit limit(options.threads);
  start_log(log_options(options.listeners));
  make_room_for(options.listeners);
  ServerOptions server_with = server_options(options);
  std::optional<HttpOptions> http = http_options(options.listeners);
  if (http) http->viewer = find_viewer(options.listeners.viewer);
  const auto cache = std::make_shared<StepCache>(options.cache_bytes);
  const CataloguePtr catalogue = open_all(dataset_files(options.datasets), cache);
  server_with.metrics = std::make_shared<PrometheusMetrics>();
  server_with.state = [cache] {
    const TileCache::Counts counts = cache->tiles().counts();
    return ServiceState{.cache_hits = counts.hits,
                        .cache_misses = counts.misses,
                        .cached_tiles = counts.tiles,
                        .cache_bytes = counts.bytes};
  };
  Server server(catalogue, server_with, more_listeners(http, cache));
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
      "Signals: SIGTERM and SIGINT drain, then stop; SIGHUP reads certificate and tokens again.\n"
      "Exit codes: 0 stopped as asked, 1 failed, 2 wrong options, 3 an address cannot be listened "
      "on,\n"
      "4 certificate, key or tokens cannot be used, 5 no dataset can be served.");
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
