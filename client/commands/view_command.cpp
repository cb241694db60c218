#include "client/commands/view_command.hpp"

#include <array>
#include <cmath>
#include <iostream>
#include <string_view>
#include <variant>

#include "client/commands/program.hpp"
#include "common/base/number_text.hpp"
#include "common/net/endpoint.hpp"
#include "common/request/threshold_parser.hpp"

namespace multitetra {
namespace {

// Letters, digits and a few harmless signs stay; every other byte is written as %XX.
std::string percent_encoded(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos) {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return encoded;
}

std::string joined(const Vec3& place) {
  return shortest_text(place[0]) + "," + shortest_text(place[1]) + "," + shortest_text(place[2]);
}

Result<std::string> region_words(const std::string& word) {
  const auto region = parse_region(word);
  if (!region) return tl::unexpected(region.error());
  const std::string threshold = "=" + shortest_text(region->threshold);
  if (const auto* box = std::get_if<BoxShape>(&region->shape)) {
    return "box:" + joined(box->low) + "," + joined(box->high) + threshold;
  }
  if (const auto* ball = std::get_if<BallShape>(&region->shape)) {
    return "ball:" + joined(ball->centre) + "," + shortest_text(ball->radius) + threshold;
  }
  return fail(ErrorCode::kInvalidArgument,
              "The viewer shows boxes and balls; \"" + word + "\" is neither.");
}

// Where the page is: beside the conversation, for those who travel over HTTP.
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
  const std::uint16_t usual = server->is_secure() ? 443 : 80;
  std::string path = server->path;
  if (path.ends_with(kStreamPath)) path.resize(path.size() - kStreamPath.size());
  return site + (server->port == usual ? "" : ":" + std::to_string(server->port)) + path;
}

}  // namespace

void add_view(Command& app, ViewArguments& a) {
  Command* command =
      app.add_subcommand("view", "Print the address at which a browser shows a surface");
  command
      ->add_option("--http", a.http,
                   "Address of the server's HTTP listener (default: what --server says, else "
                   "http://127.0.0.1:7480)")
      ->type_name("ADDRESS");
  command
      ->add_option("--server", a.server,
                   "The server as other commands have it: ws://HOST:PORT is where its viewer is, "
                   "too; of tcp://HOST:PORT the viewer is taken to be at port 7480")
      ->envname("MULTITETRA_SERVER")
      ->type_name("ADDRESS");
  command->add_option("--dataset", a.dataset, "Name of the dataset (default: the first)");
  command->add_option("--isovalue", a.isovalue,
                      "Value of the surface (default: the dataset's first suggestion)");
  command->add_option("--error", a.error, "Largest allowed error, in voxels")
      ->capture_default_str();
  command->add_option("--bound", a.bound, "certified bounds the real distance, paper need not")
      ->one_of({"paper", "certified"})
      ->capture_default_str();
  command->add_option("--topology-rule", a.topology_rule, "Which flips of sign are kept")
      ->one_of({"exact", "paper"})
      ->capture_default_str();
  command
      ->add_option("--topology-tolerance", a.topology_tolerance,
                   "Features up to this many voxels may vanish")
      ->capture_default_str();
  command->add_option("--max-triangles", a.max_triangles, "The most triangles");
  command->add_option("--simplify", a.simplify, "on: a few of the triangles, within the same error")
      ->one_of({"on", "off"})
      ->capture_default_str();
  command->add_option("--clip", a.clip, "Cut the surface open in the middle of an axis")
      ->one_of({"off", "x", "y", "z"})
      ->capture_default_str();
  command
      ->add_option("--min-component", a.min_component,
                   "Hide connected components whose bounding box has a shorter diagonal, as the "
                   "dust that noise makes")
      ->within(0.0, 1e6)
      ->type_name("SAMPLES")
      ->capture_default_str();
  command->add_option("--region", a.region,
                      "Another error in a region: box:X0,Y0,Z0,X1,Y1,Z1=TAU or ball:X,Y,Z,R=TAU, "
                      "in world coordinates");
  command->footer(
      std::string(
          "Examples:\n"
          "  xdg-open \"$(multitetra-client view --dataset head --isovalue 500.5)\"\n"
          "  multitetra-client view --http https://example.org --dataset head --error 0.5\n") +
      kExitCodes);
}

Result<std::string> viewer_address(const ViewArguments& a) {
  const Result<std::string> site = site_of(a);
  if (!site) return tl::unexpected(site.error());
  if (!site->starts_with("http://") && !site->starts_with("https://")) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + *site +
                    "\" is no address of an HTTP listener; one looks like "
                    "http://127.0.0.1:7480.");
  }
  const auto is_length = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!is_length(a.error) || !is_length(a.topology_tolerance) ||
      !std::isfinite(a.isovalue.value_or(0))) {
    return fail(ErrorCode::kInvalidArgument,
                "Isovalue, error and tolerance are finite numbers, the latter two not negative.");
  }
  std::string words;
  const auto say = [&words](std::string_view name, std::string value) {
    std::erase(value, '+');  // Of exponents, which need none: in an address it stands for a blank.
    words.append(words.empty() ? "#" : "&").append(name).append("=").append(value);
  };
  const ViewArguments defaults;
  if (!a.dataset.empty()) say("dataset", percent_encoded(a.dataset));
  if (a.isovalue) say("isovalue", shortest_text(*a.isovalue));
  if (a.error != defaults.error) say("error", shortest_text(a.error));
  if (a.bound != defaults.bound) say("bound", a.bound);
  if (a.topology_rule != defaults.topology_rule) say("topology_rule", a.topology_rule);
  if (a.topology_tolerance > 0) say("topology_tolerance", shortest_text(a.topology_tolerance));
  if (a.max_triangles > 0) say("max_triangles", std::to_string(a.max_triangles));
  if (a.simplify != defaults.simplify) say("simplify", "false");
  if (a.clip != defaults.clip) say("clip", a.clip);
  if (a.min_component > 0) say("min_component", shortest_text(a.min_component));
  if (!a.region.empty()) {
    const auto region = region_words(a.region);
    if (!region) return tl::unexpected(region.error());
    say("region", *region);
  }
  return *site + (site->ends_with('/') ? "" : "/") + words;
}

int view(const ViewArguments& arguments) {
  const auto address = viewer_address(arguments);
  if (!address) return complain(kUsage, address.error().text);
  std::cout << *address << "\n";
  return kOk;
}

}  // namespace multitetra
