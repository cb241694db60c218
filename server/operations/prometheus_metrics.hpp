// Counts what a service reports about its work, as Prometheus text.
//
// Names begin with multitetra_; server/operations/README.md lists them. Labels are few and chosen
// by us: nothing that a client says becomes one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/operations/service_observer.hpp"

namespace multitetra {

// Blocks of files behind addresses.
struct BlockState {
  std::uint64_t memory_hits = 0;
  std::uint64_t disk_hits = 0;
  std::uint64_t fetched = 0;  // From their stores,
  std::uint64_t fetched_bytes = 0;
  // Repeated requests to stores.
  std::uint64_t retries = 0;
  std::uint64_t failures = 0;      // Requests that failed for good.
  std::uint64_t evictions = 0;     // From memory.
  std::uint64_t memory_bytes = 0;  // Now.
};

// A server behind a gateway.
struct UpstreamState {
  std::string name = {};  // Its address.
  bool is_up = false;     // It could be reached, and is not left out.
  std::uint64_t damaged_tiles = 0;
};

// Values sampled on each scrape.
struct ServiceState {
  std::uint64_t cache_hits = 0;
  std::uint64_t cache_misses = 0;
  std::size_t cached_tiles = 0;
  std::size_t cache_bytes = 0;
  std::size_t waiting_jobs = 0;  // For a worker.
  // Bytes of steps that wait for their clients.
  std::size_t waiting_bytes = 0;
  std::size_t datasets = 0;
  bool is_draining = false;
  // Set for a server.
  std::optional<BlockState> blocks = {};
  // Set for a gateway.
  std::vector<UpstreamState> upstreams = {};
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
  void sent(ProtocolName protocol, std::size_t bytes) override;

  // Text format 0.0.4. The state's values are written as they are.
  [[nodiscard]] std::string text(const ServiceState& state);

 private:
  struct Families;
  static void add_block_metrics(Families& families, const BlockState& blocks);
  std::unique_ptr<Families> families_;
};

// The memory of this process, in bytes; 0 where the system does not report it.
[[nodiscard]] std::size_t resident_bytes();

}  // namespace multitetra
