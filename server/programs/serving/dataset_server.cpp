#include "server/programs/serving/dataset_server.hpp"

#include <memory>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "server/operations/heap_trimmer.hpp"
#include "server/operations/log.hpp"
#include "server/programs/serving/coalescing_task.hpp"
#include "server/programs/serving/served_datasets.hpp"
#include "server/programs/thread_options.hpp"
#include "server/transport/server.hpp"

namespace multitetra {
namespace {

// After SIGHUP. What cannot be read changes nothing but the log.
void offer_again(Server& server, ServedDatasets& datasets) {
  try {
    const CataloguePtr catalogue = datasets.read();
    server.offer(catalogue);
    log_line(LogLevel::kInfo, "datasets read again",
             {{"datasets", static_cast<std::uint64_t>(catalogue->size())}});
  } catch (const std::exception& error) {
    log_line(LogLevel::kError, std::string("the previous datasets stay in use: ") + error.what(),
             {});
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

}  // namespace

int serve_until_stopped(const ServeOptions& options, const BackgroundTask& beside) {
  trim_heap();
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
  CoalescingTask* asked = nullptr;  // There before the server runs.
  server_with.when_reloaded = [&asked] { asked->ask(); };
  Server server(catalogue, server_with, listeners);
  // Datasets may be many, and on slow disks: they are not read by the thread that serves.
  CoalescingTask rescan([&] { offer_again(server, datasets); });
  asked = &rescan;
  for (const std::string& url : server.urls()) log_line(LogLevel::kInfo, "listening on " + url, {});
  std::shared_ptr<void> work;
  if (beside) work = beside({.urls = server.urls(), .read_again = [&rescan] { rescan.ask(); }});
  server.run();
  work.reset();
  log_line(LogLevel::kInfo, "stopped", {});
  return kOk;
}

}  // namespace multitetra
