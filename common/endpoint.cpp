#include "common/endpoint.hpp"

#include <charconv>
#include <optional>

namespace multitetra {
namespace {

constexpr std::string_view kScheme = "tcp://";

std::optional<std::uint16_t> port_from(std::string_view digits) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return port;
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

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  const auto reject = [text] {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) +
                    "\" is no server address; write tcp://HOST:PORT, for example " +
                    to_string(Endpoint{.host = "127.0.0.1"}) + ".");
  };
  const auto parts = split_host(text.starts_with(kScheme) ? text.substr(kScheme.size()) : text);
  if (!parts || parts->first.empty() || parts->first.find('/') != std::string_view::npos) {
    return reject();
  }
  Endpoint endpoint{.host = std::string(parts->first)};
  if (parts->second.empty()) return endpoint;
  const auto port =
      parts->second.front() == ':' ? port_from(parts->second.substr(1)) : std::nullopt;
  if (!port) return reject();
  endpoint.port = *port;
  return endpoint;
}

std::string to_string(const Endpoint& endpoint) {
  const bool is_ipv6 = endpoint.host.find(':') != std::string::npos;
  const std::string host = is_ipv6 ? "[" + endpoint.host + "]" : endpoint.host;
  return std::string(kScheme) + host + ":" + std::to_string(endpoint.port);
}

}  // namespace multitetra
