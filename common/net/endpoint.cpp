#include "common/net/endpoint.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "common/base/parse_number.hpp"

namespace multitetra {
namespace {

struct Scheme {
  std::string_view prefix;
  Transport transport;
  std::uint16_t port;  // The default port.
};
// If two schemes have the same transport, the first is used for output.
constexpr std::array<Scheme, 6> kSchemes = {{{"tcp://", Transport::kTcp, kDefaultPort},
                                             {"tls://", Transport::kTls, kDefaultPort},
                                             {"ws://", Transport::kWebSocket, 80},
                                             {"wss://", Transport::kSecureWebSocket, 443},
                                             {"http://", Transport::kWebSocket, 80},
                                             {"https://", Transport::kSecureWebSocket, 443}}};

const Scheme& scheme_of(Transport transport) {
  return *std::find_if(kSchemes.begin(), kSchemes.end(),
                       [&](const Scheme& scheme) { return scheme.transport == transport; });
}

// Splits "[ADDRESS]REST" or "HOSTREST" where REST is empty or starts with a colon.
std::optional<std::pair<std::string_view, std::string_view>> split_host(std::string_view text) {
  if (text.starts_with('[')) {
    const std::size_t close = text.find(']');
    if (close == std::string_view::npos) return std::nullopt;
    return std::pair(text.substr(1, close - 1), text.substr(close + 1));
  }
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::pair(text, std::string_view());
  return std::pair(text.substr(0, colon), text.substr(colon));
}

// Returns whether `text` can be part of a request line: printable ASCII without blanks.
bool is_path(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

// Parses host and port from `text`, which has no scheme and no path.
std::optional<Endpoint> address_from(std::string_view text, const Scheme& scheme) {
  const auto parts = split_host(text);
  if (!parts || parts->first.empty() || parts->first.find('/') != std::string_view::npos) {
    return std::nullopt;
  }
  Endpoint endpoint{
      .host = std::string(parts->first), .port = scheme.port, .transport = scheme.transport};
  if (text.find_first_not_of("0123456789") == std::string_view::npos) {
    const auto port = parse_number<std::uint16_t>(text);
    if (!port) return std::nullopt;
    endpoint.host = "127.0.0.1";
    endpoint.port = *port;
    return endpoint;
  }
  if (parts->second.empty()) return endpoint;
  if (parts->second.front() != ':') return std::nullopt;
  const auto port = parse_number<std::uint16_t>(parts->second.substr(1));
  if (!port) return std::nullopt;
  endpoint.port = *port;
  return endpoint;
}

std::optional<Endpoint> endpoint_from(std::string_view text, const Scheme& scheme) {
  if (!Endpoint{.host = {}, .transport = scheme.transport}.is_web_socket()) {
    return address_from(text, scheme);
  }
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::string_view path = text.substr(slash);
  auto endpoint = address_from(text.substr(0, slash), scheme);
  if (!endpoint || !is_path(path)) return std::nullopt;
  endpoint->path = path;
  if (!path.ends_with('/') && !path.empty()) return endpoint;
  while (endpoint->path.ends_with('/')) endpoint->path.pop_back();
  endpoint->path += kStreamPath;
  return endpoint;
}

tl::unexpected<Error> no_address(std::string_view text, const std::string& right) {
  return fail(ErrorCode::kInvalidArgument,
              "\"" + std::string(text) + "\" is not a server address; write " + right +
                  ", for example " + to_string(Endpoint{.host = "127.0.0.1"}) + ".");
}

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  const Scheme& tcp = kSchemes.front();
  const bool has_scheme = text.starts_with(tcp.prefix);
  const auto endpoint = endpoint_from(has_scheme ? text.substr(tcp.prefix.size()) : text, tcp);
  if (!endpoint) return no_address(text, "tcp://HOST:PORT");
  return *endpoint;
}

Result<Endpoint> parse_server_url(std::string_view text) {
  const auto scheme = std::find_if(kSchemes.begin(), kSchemes.end(), [&](const Scheme& known) {
    return text.starts_with(known.prefix);
  });
  const auto endpoint = scheme == kSchemes.end()
                            ? endpoint_from(text, kSchemes.front())
                            : endpoint_from(text.substr(scheme->prefix.size()), *scheme);
  if (!endpoint) {
    return no_address(text, "tcp://HOST:PORT, tls://HOST:PORT, ws://HOST:PORT or wss://HOST:PORT");
  }
  return *endpoint;
}

bool is_this_machine(std::string_view host) {
  const std::string name(host);
  std::array<unsigned char, sizeof(in6_addr)> address{};
  if (inet_pton(AF_INET, name.c_str(), address.data()) == 1) return address[0] == 127;
  if (inet_pton(AF_INET6, name.c_str(), address.data()) == 1) {
    return std::memcmp(address.data(), &in6addr_loopback, address.size()) == 0;
  }
  return host == "localhost";
}

std::string to_string(const Endpoint& endpoint) {
  const bool is_ipv6 = endpoint.host.find(':') != std::string::npos;
  const std::string host = is_ipv6 ? "[" + endpoint.host + "]" : endpoint.host;
  return std::string(scheme_of(endpoint.transport).prefix) + host + ":" +
         std::to_string(endpoint.port) + endpoint.path;
}

}  // namespace multitetra
