// What `multitetra-gateway` can be told, and what follows from it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "server/gateway/door_options.hpp"
#include "server/relay/relay_server.hpp"

namespace multitetra {

// As users write it.
struct GatewayOptions {
  DoorOptions doors = {.tcp = "off"};
  std::vector<std::string> upstreams = {};
  std::string upstream_ca = {};
  std::string upstream_token_file = {};
  std::size_t cache_bytes = RelayOptions{}.tile_bytes;
};

void add_gateway_options(CLI::App& command, GatewayOptions& options);

// Throws CLI::ValidationError that names the option.
[[nodiscard]] RelayServerOptions relay_options(const GatewayOptions& options);

}  // namespace multitetra
