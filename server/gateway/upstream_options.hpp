// The servers behind a gateway, and the time limits for them.
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "common/net/endpoint.hpp"
#include "server/gateway/upstream_secrets.hpp"

namespace multitetra {

struct UpstreamOptions {
  std::vector<Endpoint> upstreams = {};
  UpstreamSecrets secrets = {};
  std::chrono::milliseconds connect_timeout{3'000};  // Until Welcome.
  // The longest time without a message of a connected server.
  std::chrono::milliseconds silence{10'000};
  std::chrono::milliseconds failover_timeout{
      30'000};  // Without a server for a stream, before it fails.
  // The wait before a failed server is tried again, doubled from time to time up to the longest.
  std::chrono::milliseconds least_backoff{100};
  std::chrono::milliseconds most_backoff{5'000};
  std::chrono::milliseconds left_out{60'000};  // After a tile that is damaged.
  // The time for which a listing is cached.
  std::chrono::milliseconds list_lifetime{2'000};
  // Bytes of cached tiles.
  std::size_t tile_bytes = std::size_t{256} << 20;
};

}  // namespace multitetra
