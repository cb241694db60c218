// multitetra-gateway: the doors of a server in front of several servers.

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "server/gateway/http_door.hpp"
#include "server/relay/relay_server.hpp"

namespace multitetra {
namespace {

enum ExitCode { kOk = 0, kFailed = 1, kUsage = 2 };

struct Arguments {
  std::vector<std::string> upstreams;
  std::string http = http_url(HttpOptions{}.listen);
  std::string tcp = "off";
  std::vector<std::string> allowed_origins;
  std::string viewer;
  std::size_t max_connections = 4096;
  double max_requests = 1000;
  std::uint64_t max_mesh_triangles = HttpOptions{}.max_mesh_triangles;
  std::uint64_t mesh_cache_bytes = HttpOptions{}.mesh_cache_bytes;
};

template <typename Parse>
Endpoint parsed(const char* option, const std::string& text, const Parse& parse) {
  const Result<Endpoint> endpoint = parse(text);
  if (!endpoint) throw std::invalid_argument(std::string(option) + ": " + endpoint.error().text);
  return *endpoint;
}

int serve(const Arguments& arguments) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("multitetra-gateway"));
  RelayServerOptions options{.stop_on_signals = true};
  const auto tcp_endpoint = [](const std::string& text) { return parse_endpoint(text); };
  for (const std::string& upstream : arguments.upstreams) {
    options.relay.upstreams.push_back(parsed("--upstream", upstream, tcp_endpoint));
  }
  if (arguments.http != "off") {
    options.http = HttpOptions{.listen = parsed("--http", arguments.http, parse_http_endpoint),
                               .allowed_origins = arguments.allowed_origins,
                               .max_mesh_triangles = arguments.max_mesh_triangles,
                               .mesh_cache_bytes = arguments.mesh_cache_bytes,
                               .viewer = find_viewer(arguments.viewer)};
  }
  if (arguments.tcp != "off") {
    options.tcp = TcpDoorOptions{.listen = parsed("--tcp", arguments.tcp, tcp_endpoint)};
  }
  options.keeper.connections = {.total = arguments.max_connections,
                                .per_name = arguments.max_connections};
  options.keeper.requests = {.per_second = arguments.max_requests,
                             .burst = 3 * arguments.max_requests};
  if (!options.http && !options.tcp) throw std::invalid_argument("Both doors are off.");
  RelayServer relay(options);
  if (options.tcp) spdlog::info("listening on {}", to_string(relay.tcp()));
  if (options.http) spdlog::info("listening on {}", http_url(relay.http()));
  relay.run();
  spdlog::info("stopped");
  return kOk;
}

int run(int argc, char** argv) {
  CLI::App program(
      "Serves what other servers offer, spread by dataset; when one of them is lost, another that "
      "has the dataset goes on.",
      "multitetra-gateway");
  program.set_version_flag("--version", "multitetra-gateway " MULTITETRA_VERSION);
  Arguments a;
  program
      .add_option("--upstream", a.upstreams,
                  "A server's address, tcp://HOST:PORT; servers with the same datasets stand in "
                  "for each other (repeatable)")
      ->required();
  program
      .add_option("--http", a.http, "Address and port for HTTP and WebSockets; off: no such door")
      ->capture_default_str();
  program.add_option("--tcp", a.tcp, "Address and port for frames over TCP; off: no such door")
      ->capture_default_str();
  program.add_option("--allow-origin", a.allowed_origins,
                     "Web pages of this origin may use the HTTP door besides its own; * allows all "
                     "(repeatable)");
  program.add_option("--viewer", a.viewer, "Folder of the web viewer's files, served at /");
  program.add_option("--max-connections", a.max_connections, "Through all doors")
      ->capture_default_str();
  program.add_option("--max-requests", a.max_requests, "Requests of one address in a second")
      ->capture_default_str();
  program
      .add_option("--max-mesh-triangles", a.max_mesh_triangles,
                  "The most triangles of a mesh in one HTTP response")
      ->capture_default_str();
  program
      .add_option("--mesh-cache-bytes", a.mesh_cache_bytes,
                  "Disk for mesh files that are kept for the next HTTP request")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/false))
      ->capture_default_str();
  program.footer(
      "Example:\n"
      "  multitetra-gateway --upstream tcp://a:7410 --upstream tcp://b:7410 --http 0.0.0.0:7480\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage.");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kOk : kUsage;
  }
  return serve(a);
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "multitetra-gateway: " << error.what() << "\n";
    return multitetra::kFailed;
  }
}
