#include "server/operations/prometheus_metrics.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

// Returns whether the text contains exactly this line.
bool has(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

const ClientFacts kWebSocketClient = {
    .protocol = "websocket", .connection = 1, .peer = "192.0.2.7:1234"};

TEST(PrometheusMetrics, CountRequestsTilesBytesAndTimesByOutcome) {
  PrometheusMetrics metrics;
  metrics.connected(kWebSocketClient);
  metrics.request_began(kWebSocketClient, "stream");
  EXPECT_TRUE(has(metrics.text({}), "multitetra_requests_running{kind=\"stream\"} 1"));
  metrics.request_ended(kWebSocketClient, {.dataset = "head",
                                           .steps = 2,
                                           .tiles = 5,
                                           .bytes = 1000,
                                           .seconds_to_first_tile = 0.02,
                                           .seconds_to_last_tile = 0.3,
                                           .seconds = 0.3});
  metrics.request_began(kWebSocketClient, "stream");
  metrics.request_ended(kWebSocketClient, {.tiles = 1, .bytes = 10, .outcome = "cancelled"});
  const std::string text = metrics.text({});
  EXPECT_TRUE(has(text,
                  "multitetra_requests_total{kind=\"stream\",outcome=\"complete\","
                  "transport=\"websocket\"} 1"));
  EXPECT_TRUE(has(text,
                  "multitetra_requests_total{kind=\"stream\",outcome=\"cancelled\","
                  "transport=\"websocket\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_requests_running{kind=\"stream\"} 0"));
  EXPECT_TRUE(has(text, "multitetra_tiles_total 6"));
  EXPECT_TRUE(has(text, "multitetra_tile_bytes_total 1010"));
  EXPECT_TRUE(has(text, "multitetra_first_tile_seconds_count{transport=\"websocket\"} 1"));
  EXPECT_TRUE(
      has(text, "multitetra_first_tile_seconds_bucket{transport=\"websocket\",le=\"0.01\"} 0"));
  EXPECT_TRUE(
      has(text, "multitetra_first_tile_seconds_bucket{transport=\"websocket\",le=\"0.025\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_last_tile_seconds_count{transport=\"websocket\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_build_info{version=\"" MULTITETRA_VERSION "\"} 1"));
}

TEST(PrometheusMetrics, MeasureTheTimeOfHttpReplies) {
  PrometheusMetrics metrics;
  metrics.http_answered({}, {.kind = "isosurface", .status = 200, .seconds = 0.3});
  const std::string text = metrics.text({});
  const std::string name = "multitetra_http_answer_seconds";
  EXPECT_TRUE(has(text, name + "_count{kind=\"isosurface\"} 1"));
  EXPECT_TRUE(has(text, name + "_bucket{kind=\"isosurface\",le=\"0.25\"} 0"));
  EXPECT_TRUE(has(text, name + "_bucket{kind=\"isosurface\",le=\"0.5\"} 1"));
}

TEST(PrometheusMetrics, CountReadsOfDatasets) {
  PrometheusMetrics metrics;
  ServiceState state;
  state.blocks = BlockState{.memory_hits = 7,
                            .disk_hits = 2,
                            .fetched = 3,
                            .fetched_bytes = 4000,
                            .retries = 5,
                            .failures = 1,
                            .evictions = 6,
                            .memory_bytes = 3000};
  (void)metrics.text(state);
  state.blocks->memory_hits = 8;
  const std::string text = metrics.text(state);
  EXPECT_TRUE(has(text, "multitetra_block_hits_total{where=\"memory\"} 8"));
  EXPECT_TRUE(has(text, "multitetra_block_hits_total{where=\"disk\"} 2"));
  EXPECT_TRUE(has(text, "multitetra_block_fetches_total 3"));
  EXPECT_TRUE(has(text, "multitetra_block_fetched_bytes_total 4000"));
  EXPECT_TRUE(has(text, "multitetra_block_retries_total 5"));
  EXPECT_TRUE(has(text, "multitetra_block_failures_total 1"));
  EXPECT_TRUE(has(text, "multitetra_block_evictions_total 6"));
  EXPECT_TRUE(has(text, "multitetra_block_bytes 3000"));
}

TEST(PrometheusMetrics, CountConnectionsRefusalsAndErrorsByCode) {
  PrometheusMetrics metrics;
  for (const std::string code : {"damaged_data", "internal", "unauthenticated"}) {
    const std::string labels = "{code=\"" + code + "\",transport=\"http\"}";
    EXPECT_TRUE(has(metrics.text({}), "multitetra_errors_total" + labels + " 0")) << code;
  }
  metrics.connected(kWebSocketClient);
  metrics.connected(kWebSocketClient);
  metrics.disconnected(kWebSocketClient, 1.5);
  metrics.refused(kWebSocketClient, "connections");
  metrics.error_answered(kWebSocketClient, {ErrorCode::kUnknownDataset, "No."}, 3);
  metrics.request_ended(kWebSocketClient,
                        {.outcome = "internal", .failure = Error{ErrorCode::kInternal, "No."}});
  metrics.sent("websocket", 123);
  metrics.step_made(0.2);
  const std::string text = metrics.text({});
  EXPECT_TRUE(has(text, "multitetra_connections_total{transport=\"websocket\"} 2"));
  EXPECT_TRUE(has(text, "multitetra_sessions{transport=\"websocket\"} 1"));
  EXPECT_TRUE(
      has(text, "multitetra_refused_total{limit=\"connections\",transport=\"websocket\"} 1"));
  EXPECT_TRUE(
      has(text, "multitetra_errors_total{code=\"unknown_dataset\",transport=\"websocket\"} 1"))
      << text;
  EXPECT_TRUE(has(text, "multitetra_errors_total{code=\"internal\",transport=\"websocket\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_sent_bytes_total{transport=\"websocket\"} 123"));
  EXPECT_TRUE(has(text, "multitetra_step_seconds_count 1"));
}

TEST(PrometheusMetrics, ShowTheStateOfCacheQueueAndProcess) {
  PrometheusMetrics metrics;
  (void)metrics.text({.cache_hits = 3});
  const std::string text = metrics.text({.cache_hits = 7,
                                         .cache_misses = 2,
                                         .cached_tiles = 4,
                                         .cache_bytes = 4096,
                                         .waiting_jobs = 9,
                                         .waiting_bytes = 77,
                                         .datasets = 2,
                                         .is_draining = true});
  EXPECT_TRUE(has(text, "multitetra_cache_hits_total 7"));
  EXPECT_TRUE(has(text, "multitetra_cache_misses_total 2"));
  EXPECT_TRUE(has(text, "multitetra_cached_tiles 4"));
  EXPECT_TRUE(has(text, "multitetra_cache_bytes 4096"));
  EXPECT_TRUE(has(text, "multitetra_queue_depth 9"));
  EXPECT_TRUE(has(text, "multitetra_queue_bytes 77"));
  EXPECT_TRUE(has(text, "multitetra_datasets 2"));
  EXPECT_TRUE(has(text, "multitetra_draining 1"));
  EXPECT_GT(resident_bytes(), 1U << 20);
}

TEST(PrometheusMetrics, ShowFailedReloadsAndWhenTheCertificateExpires) {
  PrometheusMetrics metrics;
  const std::string before = metrics.text({});
  EXPECT_FALSE(has(before, "multitetra_certificate_expiry_timestamp_seconds"));
  EXPECT_TRUE(has(before, "multitetra_reload_failures_total{what=\"certificate\"} 0"));
  EXPECT_TRUE(has(before, "multitetra_last_reload_failed{what=\"datasets\"} 0"));
  metrics.reloaded("certificate", true);
  metrics.reloaded("certificate", true);
  metrics.reloaded("certificate", false);
  metrics.reloaded("datasets", true);
  const std::string text = metrics.text({.certificate_expires = 1'800'000'000});
  EXPECT_TRUE(has(text, "multitetra_reload_failures_total{what=\"certificate\"} 2"));
  EXPECT_TRUE(has(text, "multitetra_reload_failures_total{what=\"datasets\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_last_reload_failed{what=\"certificate\"} 0"));
  EXPECT_TRUE(has(text, "multitetra_last_reload_failed{what=\"datasets\"} 1"));
  EXPECT_TRUE(has(text, "multitetra_certificate_expiry_timestamp_seconds 1800000000")) << text;
}

TEST(PrometheusMetrics, CountStreamsThatAnUpstreamLost) {
  PrometheusMetrics metrics;
  const std::string text = metrics.text(
      {.upstreams = {{.name = "tcp://a", .is_up = false, .damaged_tiles = 1, .lost_streams = 4}}});
  EXPECT_TRUE(has(text, "multitetra_upstream_lost_streams_total{upstream=\"tcp://a\"} 4"));
  EXPECT_TRUE(has(text, "multitetra_upstream_up{upstream=\"tcp://a\"} 0"));
}

}  // namespace
}  // namespace multitetra
