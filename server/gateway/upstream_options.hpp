// Which servers are behind a gateway, and how much patience it has with them.
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
  std::chrono::milliseconds silence{10'000};         // Of a server that is listened to.
  std::chrono::milliseconds patience{30'000};     // Without a server for a stream, before it fails.
  std::chrono::milliseconds least_backoff{100};   // Before a server that failed is tried again,
  std::chrono::milliseconds most_backoff{5'000};  // doubled each time up to this.
  std::chrono::milliseconds left_out{60'000};     // After a tile that is damaged.
  std::chrono::milliseconds list_lifetime{2'000};   // How long what servers offer is believed.
  std::size_t tile_bytes = std::size_t{256} << 20;  // Of tiles that passed and are kept.
};

}  // namespace multitetra
