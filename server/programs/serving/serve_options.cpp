#include "server/programs/serving/serve_options.hpp"

#include <algorithm>
#include <chrono>

#include "server/programs/thread_options.hpp"

namespace multitetra {
void add_serve_options(Command& command, ServeOptions& o) {
  command.add_option(
      "datasets", o.datasets,
      "Dataset files (.mtd) and folders of them: paths, addresses (https://host/head.mtd) and "
      "buckets (s3://bucket/head.mtd, s3://bucket/folder/); SIGHUP reads them again. Volumes are "
      "prepared first, as by `view`");
  command.add_option("--volume-cache", o.volume_cache,
                     "Folder of datasets prepared from volumes; default: multitetra in "
                     "$XDG_CACHE_HOME or ~/.cache");
  add_threads_option(command, o.threads);
  add_listener_options(command, o.listeners);
  command.begin_group(kLimitsGroup);
  command
      .add_option(
          "--max-triangles", o.max_triangles,
          "Most triangles of a final step; the reply to a larger request states an error that fits")
      ->capture_default_str();
  add_seconds(command, "--max-request-seconds", o.max_request_seconds,
              "Most worker time of one request, without its pauses for others");
  add_seconds(command, "--max-waiting-seconds", o.max_waiting_seconds,
              "Most estimated worker time of all waiting requests of an address or token; "
              "rejections have a retry delay");
  add_bytes(command, "--cache-bytes", o.cache_bytes,
            "Memory for cached tiles, for example 512MiB; 0: no cache");
  command.begin_group("Bricks and remote datasets");
  add_bytes(command, "--brick-bytes", o.brick_bytes,
            "Memory for decompressed bricks and blocks of remote datasets");
  command.add_option(
      "--cache-dir", o.cache_dir,
      "Local folder that caches blocks of remote datasets; several servers may share it");
  add_bytes(command, "--cache-dir-bytes", o.cache_dir_bytes,
            "Size limit of that folder; the least recently used blocks are evicted first");
  command
      .add_option("--store-connections", o.store_connections,
                  "Most concurrent connections to one host, and prefetch requests")
      ->within(1, 256)
      ->capture_default_str();
  add_seconds(command, "--store-seconds", o.store_seconds,
              "Timeout of one request to a store, with all its retries");
}

RemoteFilesOptions file_options(const ServeOptions& o) {
  HttpStoreOptions http;
  const auto connections = static_cast<std::size_t>(o.store_connections);
  http.connections = connections;
  if (o.store_seconds > 0) http.deadline = milliseconds(o.store_seconds);
  http.stall_timeout =
      std::min(http.stall_timeout, std::chrono::ceil<std::chrono::seconds>(http.deadline));
  http.connect_timeout = std::min(http.connect_timeout, http.stall_timeout);
  http.cooldown_after_failure = std::chrono::seconds(2);
  return {.memory_bytes = o.brick_bytes,
          .folder = o.cache_dir,
          .folder_bytes = o.cache_dir_bytes,
          .fetchers = connections,
          .http = http};
}

ServerOptions server_options(const ServeOptions& o) {
  ServerOptions options = server_options(o.listeners);
  // Each step uses all threads. An address has at most two workers; the others keep other clients
  // from waiting.
  options.service.workers = o.threads == 1 ? 1 : 4;
  options.service.limits = {.request_time = milliseconds(o.max_request_seconds),
                            .max_triangles = o.max_triangles,
                            .waiting_time = milliseconds(o.max_waiting_seconds)};
  return options;
}

}  // namespace multitetra
