// `multitetra-client view`: prints the URL of the browser viewer for a surface.
#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/commands/program.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/cli/surface_options.hpp"
#include "common/net/endpoint.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {
namespace {

struct ViewArguments {
  // The URL of the server's HTTP listener; empty: derived from `server`.
  std::string http = {};
  // The server's address, as in other commands.
  std::string server = {};
  std::string dataset = {};  // Empty: the first one served.
  SurfaceQuery query = {};
  // The fields given by the user: name and value as the viewer reads them.
  std::vector<std::pair<std::string, std::string>> fields = {};
  std::string up = "z";      // The axis that points up: "x", "-z", ...
  std::string clip = "off";  // Or the axis along which the surface is clipped.
};

// Request fields that the viewer accepts in its URL.
constexpr std::array<std::string_view, 12> kViewerFields = {
    "isovalue",      "error",    "quality", "bound",         "topology_rule", "topology_tolerance",
    "max_triangles", "simplify", "region",  "min_component", "color_by",      "colors"};

// Returns kInvalidArgument for queries that the viewer cannot show.
Result<void> check_shown(const SurfaceQuery& query) {
  DatasetInfo info;
  info.suggested_isovalues = {0};
  if (const auto valid = requests_for(query, info); !valid) return tl::unexpected(valid.error());
  if (query.isovalues.size() > 1) {
    return fail(ErrorCode::kInvalidArgument,
                "--isovalue: give one isovalue; add more in the viewer.");
  }
  const auto& regions = query.request.thresholds.regions;
  if (regions.size() > 1 ||
      (regions.size() == 1 && std::holds_alternative<HalfSpaceShape>(regions.front().shape))) {
    return fail(ErrorCode::kInvalidArgument, "--region: the viewer shows one box or ball.");
  }
  return {};
}

// Returns the URL of the page, which the server's HTTP listener serves.
Result<std::string> site_of(const ViewArguments& a) {
  constexpr std::string_view kHttpPort = "7480";
  if (!a.http.empty()) return a.http;
  if (a.server.empty()) return "http://127.0.0.1:" + std::string(kHttpPort);
  const auto server = parse_server_url(a.server);
  if (!server) return fail(ErrorCode::kInvalidArgument, "--server: " + server.error().text);
  const bool is_ipv6 = server->host.find(':') != std::string::npos;
  const std::string site = (server->is_secure() ? "https://" : "http://") +
                           (is_ipv6 ? "[" + server->host + "]" : server->host);
  if (!server->is_web_socket()) return site + ":" + std::string(kHttpPort);
  const std::uint16_t default_port = server->is_secure() ? 443 : 80;
  std::string path = server->path;
  if (path.ends_with(kStreamPath)) path.resize(path.size() - kStreamPath.size());
  return site + (server->port == default_port ? "" : ":" + std::to_string(server->port)) + path;
}

// Returns a URL for client/web/src/state/url_state.ts. Returns kInvalidArgument if the server's
// address has no viewer.
Result<std::string> viewer_address(const ViewArguments& a) {
  const Result<std::string> site = site_of(a);
  if (!site) return tl::unexpected(site.error());
  if (!site->starts_with("http://") && !site->starts_with("https://")) {
    return fail(ErrorCode::kInvalidArgument, "\"" + *site +
                                                 "\" is not the address of an HTTP listener; "
                                                 "write for example http://127.0.0.1:7480.");
  }
  if (const auto checked = check_shown(a.query); !checked) return tl::unexpected(checked.error());
  std::string words;
  const auto say = [&words](std::string_view name, std::string_view value) {
    words.append(words.empty() ? "#" : "&")
        .append(name)
        .append("=")
        .append(percent_encoded(value, ",:="));
  };
  if (!a.dataset.empty()) say("dataset", a.dataset);
  for (const auto& [name, text] : a.fields) say(name, text);
  if (a.up != ViewArguments{}.up) say("up", a.up);
  if (a.clip != ViewArguments{}.clip) say("clip", a.clip);
  return *site + (site->ends_with('/') ? "" : "/") + words;
}

int view(const ViewArguments& arguments) {
  const std::string address = value_or_usage_error(viewer_address(arguments));
  const auto server = parse_server_url(arguments.server);
  if (arguments.http.empty() && server && !server->is_web_socket()) {
    std::cerr << "Assuming that the viewer is at port 7480; --http ADDRESS sets another address.\n";
  }
  std::cout << address << "\n";
  return kOk;
}

}  // namespace

void add_view(Command& program, Run& run) {
  const auto a = std::make_shared<ViewArguments>();
  Command* command =
      program.add_subcommand("view", "Print the address that shows a surface in a browser");
  command
      ->add_option("--http", a->http,
                   "Address of the viewer; default: the host of --server, or "
                   "http://127.0.0.1:7480")
      ->type_name("ADDRESS");
  command
      ->add_option("--server", a->server,
                   "Address of the server; with ws://HOST:PORT the viewer is at the same port, "
                   "with tcp://HOST:PORT at port 7480")
      ->envname("MULTITETRA_SERVER")
      ->type_name("ADDRESS");
  command->add_option("--dataset", a->dataset, "Name of the dataset (default: the first)");
  for (const RequestField& field : request_fields()) {
    if (std::find(kViewerFields.begin(), kViewerFields.end(), field.name) == kViewerFields.end()) {
      continue;
    }
    add_request_option(*command, field, [a, &field](const std::string& text) {
      const FieldError wrong = field.set(field, text, a->query);
      const bool is_count = field.name == "max_triangles";
      a->fields.emplace_back(field.name,
                             is_count ? std::to_string(a->query.request.max_triangles) : text);
      return wrong;
    });
  }
  command->add_option("--up", a->up, "World axis that points up, such as -y")
      ->one_of({"x", "-x", "y", "-y", "z", "-z"})
      ->capture_default_str();
  command->add_option("--clip", a->clip, "Cut the surface open in the middle of an axis")
      ->one_of({"off", "x", "y", "z"})
      ->capture_default_str();
  command->footer(
      std::string(
          "Examples:\n"
          "  xdg-open \"$(multitetra-client view --dataset head --isovalue 500.5)\"\n"
          "  multitetra-client view --http https://example.org --dataset head --error 0.5\n") +
      kExitCodes);
  command->callback([a, &run] { run = [a] { return view(*a); }; });
}

}  // namespace multitetra
