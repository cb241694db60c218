#include "server/operations/prometheus_metrics.hpp"

#include <unistd.h>

#include <fstream>

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

namespace multitetra {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Registry;

const Histogram::BucketBoundaries kSeconds = {0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1,
                                              2.5,   5,    10,    20,   30,  60,   120};

Family<Counter>& counter(Registry& registry, const char* name, const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry);
}
Family<Gauge>& gauges(Registry& registry, const char* name, const char* help) {
  return BuildGauge().Name(name).Help(help).Register(registry);
}
Gauge& gauge(Registry& registry, const char* name, const char* help) {
  return gauges(registry, name, help).Add({});
}
Family<Histogram>& histogram(Registry& registry, const char* name, const char* help) {
  return BuildHistogram().Name(name).Help(help).Register(registry);
}

// Raises a counter to a value that is counted elsewhere.
void raise_to(Counter& counter, std::uint64_t value) {
  const double more = static_cast<double>(value) - counter.Value();
  if (more > 0) counter.Increment(more);
}

}  // namespace

struct PrometheusMetrics::Families {
  Registry registry;
  Family<Counter>& connections =
      counter(registry, "multitetra_connections_total", "Accepted connections.");
  Family<Gauge>& sessions = gauges(registry, "multitetra_sessions", "Open connections.");
  Family<Counter>& refused = counter(registry, "multitetra_refused_total",
                                     "Connections and requests rejected by a limit, by limit.");
  Family<Gauge>& running = gauges(registry, "multitetra_requests_running", "Requests in progress.");
  Family<Counter>& requests =
      counter(registry, "multitetra_requests_total", "Finished requests, by kind and outcome.");
  Family<Counter>& errors = counter(registry, "multitetra_errors_total", "Error replies, by code.");
  Family<Counter>& http_answers = counter(registry, "multitetra_http_answers_total",
                                          "HTTP replies, by kind of request and by status.");
  Family<Histogram>& http_seconds = histogram(registry, "multitetra_http_answer_seconds",
                                              "Time from an HTTP request to its reply, by kind.");
  Family<Histogram>& first_tile = histogram(registry, "multitetra_first_tile_seconds",
                                            "Time from a request to its first tile.");
  Family<Histogram>& last_tile =
      histogram(registry, "multitetra_last_tile_seconds", "Time from a request to its last tile.");
  Histogram& steps = histogram(registry, "multitetra_step_seconds", "Time of a worker for a step.")
                         .Add({}, kSeconds);
  Counter& tiles = counter(registry, "multitetra_tiles_total", "Sent tiles.").Add({});
  Counter& tile_bytes =
      counter(registry, "multitetra_tile_bytes_total", "Payload bytes of sent tiles.").Add({});
  Family<Counter>& sent =
      counter(registry, "multitetra_sent_bytes_total", "Bytes of sent messages and replies.");
  Counter& cache_hits =
      counter(registry, "multitetra_cache_hits_total", "Hits of the tile cache.").Add({});
  Counter& cache_misses =
      counter(registry, "multitetra_cache_misses_total", "Misses of the tile cache.").Add({});
  Gauge& cached_tiles = gauge(registry, "multitetra_cached_tiles", "Tiles in the cache.");
  Gauge& cache_bytes = gauge(registry, "multitetra_cache_bytes", "Bytes of the cache.");
  Gauge& waiting_jobs =
      gauge(registry, "multitetra_queue_depth", "Steps and estimates waiting for a worker.");
  Gauge& waiting_bytes =
      gauge(registry, "multitetra_queue_bytes", "Bytes of steps waiting for their clients.");
  Gauge& longest_task =
      gauge(registry, "multitetra_network_longest_task_seconds",
            "CPU time of the longest task of the network's thread, which serves all clients.");
  Gauge& datasets = gauge(registry, "multitetra_datasets", "Served datasets.");
  Family<Counter>& block_hits =
      counter(registry, "multitetra_block_hits_total",
              "Blocks of remote files found in memory or on disk, by place.");
  Counter& block_fetches =
      counter(registry, "multitetra_block_fetches_total", "Blocks fetched from stores.").Add({});
  Counter& block_fetched_bytes =
      counter(registry, "multitetra_block_fetched_bytes_total", "Bytes fetched from stores.")
          .Add({});
  Counter& block_retries =
      counter(registry, "multitetra_block_retries_total", "Retried requests to stores.").Add({});
  Counter& block_failures = counter(registry, "multitetra_block_failures_total",
                                    "Requests to stores that failed after all retries.")
                                .Add({});
  Counter& block_evictions = counter(registry, "multitetra_block_evictions_total",
                                     "Blocks and decompressed bricks evicted from memory.")
                                 .Add({});
  Gauge& block_bytes = gauge(registry, "multitetra_block_bytes",
                             "Bytes of blocks and decompressed bricks in memory.");
  Family<Gauge>& upstreams =
      gauges(registry, "multitetra_upstream_up",
             "1 while a server behind this gateway can be reached and is used.");
  Family<Counter>& damaged_tiles =
      counter(registry, "multitetra_upstream_damaged_tiles_total",
              "Tiles sent by a server behind this gateway that do not match its manifest.");
  Family<Counter>& lost_streams =
      counter(registry, "multitetra_upstream_lost_streams_total",
              "Streams interrupted by the loss of their server behind this gateway.");
  Family<Counter>& reload_failures =
      counter(registry, "multitetra_reload_failures_total",
              "Failures to load certificate, tokens or datasets; the previous ones stay in use.");
  Family<Gauge>& last_reload_failed =
      gauges(registry, "multitetra_last_reload_failed",
             "1 if the last attempt to load this has failed, for datasets also of one file.");
  Family<Gauge>& certificate = gauges(registry, "multitetra_certificate_expiry_timestamp_seconds",
                                      "When the certificate of the listeners expires.");
  Gauge& draining = gauge(registry, "multitetra_draining", "1 while the server is stopping.");
  Gauge& resident = gauge(registry, "process_resident_memory_bytes", "Resident memory.");
};

PrometheusMetrics::PrometheusMetrics() : families_(std::make_unique<Families>()) {
  gauges(families_->registry, "multitetra_build_info", "Always 1; the label is the version.")
      .Add({{"version", MULTITETRA_VERSION}})
      .Set(1);
  gauge(families_->registry, "process_start_time_seconds", "When the process began, in Unix time.")
      .SetToCurrentTime();
  // Prometheus sees the first increment only of a counter that was there before.
  for (const char* const what : {"certificate", "tokens file", "datasets", "credentials"}) {
    families_->reload_failures.Add({{"what", what}});
    families_->last_reload_failed.Add({{"what", what}});
  }
  for (const char* const transport : {"tcp", "http", "websocket"}) {
    for (int code = 0; code <= static_cast<int>(ErrorCode::kPermissionDenied); ++code) {
      const std::string code_name(name(static_cast<ErrorCode>(code)));
      families_->errors.Add({{"transport", transport}, {"code", code_name}});
    }
  }
}
PrometheusMetrics::~PrometheusMetrics() = default;

void PrometheusMetrics::connected(const ClientFacts& client) {
  families_->connections.Add({{"transport", client.protocol}}).Increment();
  families_->sessions.Add({{"transport", client.protocol}}).Increment();
}

void PrometheusMetrics::disconnected(const ClientFacts& client, double) {
  families_->sessions.Add({{"transport", client.protocol}}).Decrement();
}

void PrometheusMetrics::refused(const ClientFacts& client, const char* reason) {
  families_->refused.Add({{"transport", client.protocol}, {"limit", reason}}).Increment();
}

void PrometheusMetrics::request_began(const ClientFacts&, const char* kind) {
  families_->running.Add({{"kind", kind}}).Increment();
}

void PrometheusMetrics::request_ended(const ClientFacts& client, const RequestFacts& facts) {
  Families& f = *families_;
  f.running.Add({{"kind", facts.kind}}).Decrement();
  f.requests
      .Add({{"transport", client.protocol},
            {"kind", facts.kind},
            {"outcome", std::string(facts.outcome)}})
      .Increment();
  if (facts.failure) error_answered(client, *facts.failure, facts.request);
  f.tiles.Increment(static_cast<double>(facts.tiles));
  if (facts.tiles > 0) f.tile_bytes.Increment(static_cast<double>(facts.bytes));
  if (facts.seconds_to_first_tile) {
    f.first_tile.Add({{"transport", client.protocol}}, kSeconds)
        .Observe(*facts.seconds_to_first_tile);
  }
  if (facts.seconds_to_last_tile && facts.outcome == "complete") {
    f.last_tile.Add({{"transport", client.protocol}}, kSeconds)
        .Observe(*facts.seconds_to_last_tile);
  }
}

void PrometheusMetrics::error_answered(const ClientFacts& client, const Error& error,
                                       std::uint64_t) {
  families_->errors.Add({{"transport", client.protocol}, {"code", std::string(name(error.code))}})
      .Increment();
}

void PrometheusMetrics::http_answered(const ClientFacts&, const HttpFacts& facts) {
  families_->http_answers.Add({{"kind", facts.kind}, {"status", std::to_string(facts.status)}})
      .Increment();
  families_->http_seconds.Add({{"kind", facts.kind}}, kSeconds).Observe(facts.seconds);
}

void PrometheusMetrics::step_made(double seconds) { families_->steps.Observe(seconds); }

void PrometheusMetrics::reloaded(const char* what, bool failed) {
  families_->reload_failures.Add({{"what", what}}).Increment(failed ? 1 : 0);
  families_->last_reload_failed.Add({{"what", what}}).Set(failed ? 1 : 0);
}

void PrometheusMetrics::sent(ProtocolName protocol, std::size_t bytes) {
  families_->sent.Add({{"transport", protocol}}).Increment(static_cast<double>(bytes));
}

void PrometheusMetrics::add_block_metrics(Families& f, const BlockState& blocks) {
  raise_to(f.block_hits.Add({{"where", "memory"}}), blocks.memory_hits);
  raise_to(f.block_hits.Add({{"where", "disk"}}), blocks.disk_hits);
  raise_to(f.block_fetches, blocks.fetched);
  raise_to(f.block_fetched_bytes, blocks.fetched_bytes);
  raise_to(f.block_retries, blocks.retries);
  raise_to(f.block_failures, blocks.failures);
  raise_to(f.block_evictions, blocks.evictions);
  f.block_bytes.Set(static_cast<double>(blocks.memory_bytes));
}

std::string PrometheusMetrics::text(const ServiceState& state) {
  Families& f = *families_;
  raise_to(f.cache_hits, state.cache_hits);
  raise_to(f.cache_misses, state.cache_misses);
  f.cached_tiles.Set(static_cast<double>(state.cached_tiles));
  f.cache_bytes.Set(static_cast<double>(state.cache_bytes));
  f.waiting_jobs.Set(static_cast<double>(state.waiting_jobs));
  f.waiting_bytes.Set(static_cast<double>(state.waiting_bytes));
  f.datasets.Set(static_cast<double>(state.datasets));
  if (state.blocks) add_block_metrics(f, *state.blocks);
  for (const UpstreamState& one : state.upstreams) {
    f.upstreams.Add({{"upstream", one.name}}).Set(one.is_up ? 1 : 0);
    raise_to(f.damaged_tiles.Add({{"upstream", one.name}}), one.damaged_tiles);
    raise_to(f.lost_streams.Add({{"upstream", one.name}}), one.lost_streams);
  }
  if (state.certificate_expires) {
    f.certificate.Add({}).Set(static_cast<double>(*state.certificate_expires));
  }
  f.longest_task.Set(state.longest_task_seconds);
  f.draining.Set(state.is_draining ? 1 : 0);
  f.resident.Set(static_cast<double>(resident_bytes()));
  return prometheus::TextSerializer().prometheus::Serializer::Serialize(f.registry.Collect());
}

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t total = 0;
  std::size_t resident = 0;
  statm >> total >> resident;
  return statm ? resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace multitetra
