#include "server/programs/serving/gateway_options.hpp"

#include <algorithm>

namespace multitetra {
namespace {

Endpoint upstream_from(const std::string& text) {
  const Result<Endpoint> endpoint = parse_server_url(text);
  if (!endpoint) throw UsageError("--upstream", endpoint.error().text);
  if (endpoint->is_web_socket()) {
    throw UsageError(
        "--upstream",
        "\"" + text +
            "\" is not the address of a server; write tcp://HOST:PORT or tls://HOST:PORT.");
  }
  return *endpoint;
}

}  // namespace

void add_gateway_options(Command& command, GatewayOptions& o) {
  command
      .add_option("--upstream", o.upstreams,
                  "Address of a server, tcp://HOST:PORT or tls://HOST:PORT; servers with the same "
                  "datasets replace each other (repeatable)")
      ->delimiter(',')
      ->type_name("ADDRESS");
  command.begin_group("Upstream servers");
  command.add_option("--upstream-ca", o.upstream_ca,
                     "Trust these authorities (PEM) and no others, for tls://. Reloaded on SIGHUP");
  command.add_option(
      "--upstream-token-file", o.upstream_token_file,
      "File whose first line is the token that servers receive instead of the clients' own: "
      "all clients then have its rights, unless --tokens limits them. Reloaded on SIGHUP");
  command.begin_group();
  add_listener_options(command, o.listeners);
  command.begin_group(kLimitsGroup);
  add_bytes(command, "--cache-bytes", o.cache_bytes,
            "Memory for forwarded tiles, which are cached by digest");
}

RemoteServiceOptions remote_service_options(const GatewayOptions& o) {
  // Not an aggregate: GCC 12 destroys members that were never constructed if an initializer throws.
  RemoteServiceOptions options;
  options.upstream.tile_bytes = o.cache_bytes;
  options.upstream.warns_of_open_servers =
      o.listeners.tokens.empty() && o.upstream_token_file.empty() && is_open_to_others(o.listeners);
  options.files.ca = o.upstream_ca;
  options.files.token = o.upstream_token_file;
  options.requests = o.listeners.requests;
  for (const std::string& upstream : o.upstreams) {
    options.upstream.upstreams.push_back(upstream_from(upstream));
    if (options.upstream.upstreams.back().is_secure()) options.files.needs_tls = true;
  }
  return options;
}

}  // namespace multitetra
