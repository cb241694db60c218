// The servers behind a gateway, with their time limits.
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
  // Warn about a server that requires no token: clients of the gateway need none either.
  bool warns_of_open_servers = false;
  std::chrono::milliseconds connect_timeout{3'000};  // Time until Welcome.
  // The longest silence of a connected server before it counts as lost.
  std::chrono::milliseconds silence_timeout{10'000};
  // The time for which a stream waits for a server before it fails; also the time without a message
  // from any server after which no further loss of one is tolerated, as the request may be the
  // cause.
  std::chrono::milliseconds failover_timeout{30'000};
  // The delay before a failed server is retried, doubled up to the longest.
  std::chrono::milliseconds min_backoff{100};
  std::chrono::milliseconds max_backoff{5'000};
  std::chrono::milliseconds quarantine_time{60'000};  // Exclusion after a damaged tile.
  // The time for which a listing is cached.
  std::chrono::milliseconds list_lifetime{2'000};
  // The capacity of the tile cache, in bytes.
  std::size_t tile_bytes = std::size_t{256} << 20;
};

}  // namespace multitetra
