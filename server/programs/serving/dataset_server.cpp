#include "server/programs/serving/dataset_server.hpp"

#include <atomic>
#include <memory>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/in_parallel.hpp"
#include "server/operations/log.hpp"
#include "server/programs/serving/coalescing_task.hpp"
#include "server/programs/serving/served_datasets.hpp"
#include "server/transport/server.hpp"

namespace multitetra {
namespace {

// Reloads the datasets after SIGHUP. A failure is only logged and counted. Returns whether there
// are none.
bool rescan_datasets(Server& server, ServedDatasets& datasets) {
  try {
    const CataloguePtr catalogue = datasets.read();
    server.offer(catalogue, datasets.is_complete());
    log_line(LogLevel::kInfo, "datasets reloaded",
             {{"datasets", static_cast<std::uint64_t>(catalogue->size())}});
    return catalogue->size() == 0;
  } catch (const std::exception& error) {
    server.keep_datasets(error.what());
    return false;
  }
}

// The end of a server without datasets.
ExitError nothing_to_serve(const ServedDatasets& datasets) {
  if (datasets.is_store_failing()) {
    return {kFailed, "No dataset can be read from its store; the lines above say why."};
  }
  return {kNoDataset,
          "There is no dataset to serve. What cannot be read is named above; datasets are made of "
          "volumes with: multitetra-server prepare VOLUME -o FILE.mtd"};
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
  const ThreadLimit limit(options.threads);
  begin_serving(options.listeners);
  ServerOptions server_with = server_options(options);
  const std::vector<MakeListener> listeners = http_listeners(options.listeners);
  const auto cache = std::make_shared<SurfaceCache>(options.cache_bytes);
  const auto files = std::make_shared<RemoteFiles>(file_options(options));
  ServedDatasets datasets(options.datasets, cache, files, options.readings);
  const CataloguePtr catalogue = datasets.read();
  std::atomic<bool> may_be_empty = options.readings != nullptr;
  if (catalogue->size() == 0 && !may_be_empty) throw nothing_to_serve(datasets);
  server_with.metrics->reloaded("datasets", !datasets.is_complete());
  server_with.service.cache = cache;
  server_with.service.blocks = [files] { return state_of(files->counts()); };
  CoalescingTask* rescan_task = nullptr;  // Set before the server runs.
  server_with.when_reloaded = [&rescan_task] { rescan_task->request(); };
  Server server(catalogue, server_with, listeners);
  // Reloading may take long with many datasets or slow disks, so it has its own thread.
  std::atomic<int> code = kOk;
  CoalescingTask rescan([&] {
    const bool is_last = !may_be_empty;  // What is requested later is read once more.
    if (!rescan_datasets(server, datasets) || !is_last) return;
    const ExitError failure = nothing_to_serve(datasets);
    log_line(LogLevel::kError, failure.what(), {});
    code = failure.code();
    server.stop();
  });
  rescan_task = &rescan;
  std::shared_ptr<void> work;
  if (beside) {
    work = beside({.urls = server.urls(),
                   .read_again = [&rescan] { rescan.request(); },
                   .stop_if_empty =
                       [&] {
                         may_be_empty = false;
                         rescan.request();
                       }});
  }
  serve_with_log(server);
  return code;
}

}  // namespace multitetra
