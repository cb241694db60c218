// multitetra-gateway: serves the datasets of several servers.
#include <algorithm>
#include <cstddef>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/cli/command.hpp"
#include "common/cli/command_line.hpp"
#include "common/cli/option_sources.hpp"
#include "common/cli/program.hpp"
#include "server/gateway/remote_service.hpp"
#include "server/programs/serving/listener_options.hpp"

namespace multitetra {
namespace {

// Values as given by the user.
struct GatewayOptions {
  ListenerOptions listeners = {.tcp = "off"};
  std::vector<std::string> upstreams = {};
  std::string upstream_ca = {};
  std::string upstream_token_file = {};
  std::size_t cache_bytes = UpstreamOptions{}.tile_bytes;
};

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

// Throws UsageError, which names the option.
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

int serve(const GatewayOptions& options) {
  // Servers decide what the clients' own tokens, or none, show.
  begin_serving(options.listeners, options.upstream_token_file.empty()
                                       ? ""
                                       : "all datasets of the --upstream-token-file");
  ServerOptions server = server_options(options.listeners);
  server.session.agent = "multitetra-gateway/" MULTITETRA_VERSION;
  Server gateway(remote_service(remote_service_options(options)), std::move(server),
                 http_listeners(options.listeners));
  serve_with_log(gateway);
  return kOk;
}

// Reads the configuration file and checks the options. Throws UsageError.
void complete(const Command& program, const OptionSources& sources, const GatewayOptions& options) {
  if (!sources.config_file.empty()) read_config_file(program, sources.config_file);
  if (sources.print_config) return;
  if (options.upstreams.empty()) throw UsageError("--upstream", "give the address of a server.");
  (void)remote_service_options(options);  // Throws for invalid options.
  (void)server_options(options.listeners);
  (void)http_options(options.listeners);
}

int run(int argc, char** argv) {
  Command program(
      "Forwards requests to several servers, by dataset. Streams of a lost server continue at "
      "another server.",
      "multitetra-gateway");
  GatewayOptions options;
  OptionSources sources;
  add_program_flags(program);
  add_gateway_options(program, options);
  add_option_sources(program, sources);
  program.footer(
      "Examples:\n"
      "  multitetra-gateway --upstream tcp://a:7410 --upstream tcp://b:7410 --http 0.0.0.0:7480\n"
      "  multitetra-gateway --upstream tls://a:7410 --upstream-ca ca.pem --http 0.0.0.0:443 "
      "--tls-cert\n"
      "  cert.pem --tls-key cert.key --tokens tokens\n"
      "Signals: SIGTERM and SIGINT drain, then stop; SIGHUP reloads certificates and tokens.\n"
      "Exit codes: 0 stopped by request, 1 failed, 2 wrong options, 4 certificate, key or tokens "
      "cannot be\n"
      "used, 7 cannot listen on an address.");
  program.callback([&] { complete(program, sources, options); });
  if (const auto code = parse_command_line(program, argc, argv)) return *code;
  if (!sources.print_config) return serve(options);
  std::cout << config_text(
      program, {"upstream-ca", "upstream-token-file", "tls-cert", "tls-key", "tokens", "viewer"});
  return kOk;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  return multitetra::run_program(
      "multitetra-gateway", [&] { return multitetra::run(argc, argv); },
      multitetra::print_fatal_error);
}
