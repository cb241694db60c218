#include "server/service/serve_options.hpp"

#include "server/service/thread_options.hpp"

namespace multitetra {

void add_serve_options(CLI::App& command, ServeOptions& o) {
  command.add_option("datasets", o.datasets, "Dataset files, or directories of them (.mtd)");
  add_threads_option(command, o.threads);
  add_door_options(command, o.doors);
  command
      .add_option("--max-triangles", o.max_triangles,
                  "Of a stream's final step; the refusal tells an error at which it fits")
      ->capture_default_str()
      ->group(kLimitsGroup);
  add_seconds(command, "--max-request-seconds", o.max_request_seconds,
              "Of workers' time for one request")
      ->group(kLimitsGroup);
  add_bytes(command, "--cache-bytes", o.cache_bytes,
            "Memory for encoded tiles that are kept for the next request, for example 512MiB; 0 "
            "keeps none")
      ->group(kLimitsGroup);
  add_bytes(command, "--queue-bytes", o.queue_bytes,
            "Memory for steps that wait for their clients, all together")
      ->group(kLimitsGroup);
}

ServerOptions server_options(const ServeOptions& o) {
  ReceptionOptions reception = reception_options(o.doors);
  reception.keeper.queue_bytes = o.queue_bytes == 0 ? SIZE_MAX : o.queue_bytes;
  const auto tcp = tcp_options(o.doors);
  return {.listen = tcp.value_or(TcpDoorOptions{}).listen,
          .has_tcp_door = tcp.has_value(),
          // Each step uses all threads; a second one at the same time fills what the first leaves
          // idle.
          .workers = o.threads == 1 ? std::size_t{1} : std::size_t{2},
          .heed_signals = reception.heed_signals,
          .drain_time = reception.drain_time,
          .keeper = std::move(reception.keeper),
          .session = session_options(o.doors),
          .limits = {.request_time = milliseconds(o.max_request_seconds),
                     .idle_time = milliseconds(o.doors.idle_seconds),
                     .max_triangles = o.max_triangles},
          .connection = tcp.value_or(TcpDoorOptions{}).connection};
}

}  // namespace multitetra
