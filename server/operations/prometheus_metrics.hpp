// Collects service events as Prometheus metrics.
//
// Names begin with multitetra_; server/operations/README.md lists them. Labels are few and fixed:
// none comes from client input.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Statistics of the block cache for remote datasets.
struct BlockState {
  std::uint64_t memory_hits = 0;
  std::uint64_t disk_hits = 0;
  std::uint64_t fetched = 0;  // Blocks fetched from stores.
  std::uint64_t fetched_bytes = 0;
  // Repeated requests to stores.
  std::uint64_t retries = 0;
  std::uint64_t failures = 0;   // Requests that failed after all retries.
  std::uint64_t evictions = 0;  // Blocks evicted from memory.
  std::uint64_t memory_bytes = 0;
};

// The state of one upstream of a gateway.
struct UpstreamState {
  std::string name = {};  // The upstream's address.
  bool is_up = false;     // Reachable and not excluded.
  std::uint64_t damaged_tiles = 0;
  std::uint64_t lost_streams = 0;  // Streams interrupted by the loss of this upstream.
};

// Values sampled on each scrape.
struct ServiceState {
  std::uint64_t cache_hits = 0;
  std::uint64_t cache_misses = 0;
  std::size_t cached_tiles = 0;
  std::size_t cache_bytes = 0;
  std::size_t waiting_jobs = 0;
  // Bytes reserved for waiting requests and replies.
  std::size_t waiting_bytes = 0;
  std::size_t datasets = 0;
  bool is_draining = false;
  // The longest task of the network's thread so far, in seconds of its CPU time.
  double longest_task_seconds = 0;
  // Set for a server of datasets.
  std::optional<BlockState> blocks = {};
  // Set for a gateway.
  std::vector<UpstreamState> upstreams = {};
  // Set for TLS: when the listeners' certificate expires, in seconds of Unix time.
  std::optional<std::int64_t> certificate_expires = {};
};

class PrometheusMetrics : public ServiceObserver {
 public:
  PrometheusMetrics();
  ~PrometheusMetrics() override;

  void connected(const ClientFacts& client) override;
  void disconnected(const ClientFacts& client, double seconds) override;
  void refused(const ClientFacts& client, const char* reason) override;
  void request_began(const ClientFacts& client, const char* kind) override;
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override;
  void error_answered(const ClientFacts& client, const Error& error,
                      std::uint64_t request) override;
  void http_answered(const ClientFacts& client, const HttpFacts& facts) override;
  void step_made(double seconds) override;
  void reloaded(const char* what, bool failed) override;
  void sent(ProtocolName protocol, std::size_t bytes) override;

  // Returns the metrics in text format 0.0.4, with the values of `state`.
  [[nodiscard]] std::string text(const ServiceState& state);

 private:
  struct Families;
  static void add_block_metrics(Families& families, const BlockState& blocks);
  std::unique_ptr<Families> families_;
};

// Returns the resident memory of this process in bytes; 0 if unknown.
[[nodiscard]] std::size_t resident_bytes();

}  // namespace multitetra
