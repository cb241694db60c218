// The options of `multitetra-gateway`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/cli/command.hpp"
#include "server/gateway/remote_service.hpp"
#include "server/programs/serving/listener_options.hpp"

namespace multitetra {

// Values as given by the user.
struct GatewayOptions {
  ListenerOptions listeners = {.tcp = "off"};
  std::vector<std::string> upstreams = {};
  std::string upstream_ca = {};
  std::string upstream_token_file = {};
  std::size_t cache_bytes = UpstreamOptions{}.tile_bytes;
};

void add_gateway_options(Command& command, GatewayOptions& options);

// Throws UsageError, which names the option.
[[nodiscard]] RemoteServiceOptions remote_service_options(const GatewayOptions& options);

}  // namespace multitetra
