// An address to listen on or connect to: a host, a port and a transport, as users write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultPort = 7410;
inline constexpr std::string_view kStreamPath = "/v1/stream";  // The path of WebSocket connections.
inline constexpr std::string_view kSubprotocol = "multitetra.v1";

enum class Transport {
  kTcp,              // Frames over TCP: "tcp://".
  kTls,              // Frames over TLS: "tls://".
  kWebSocket,        // "ws://"
  kSecureWebSocket,  // "wss://", over TLS.
};

struct Endpoint {
  std::string host;  // A name or an address; IPv6 addresses have no brackets here.
  std::uint16_t port = kDefaultPort;
  Transport transport = Transport::kTcp;
  // The path of a WebSocket, including its leading "/"; empty for other transports.
  std::string path = {};

  [[nodiscard]] bool is_web_socket() const {
    return transport == Transport::kWebSocket || transport == Transport::kSecureWebSocket;
  }
  [[nodiscard]] bool is_secure() const {
    return transport == Transport::kTls || transport == Transport::kSecureWebSocket;
  }
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// Parses an address to listen on: "HOST", "HOST:PORT" or "PORT" of this machine, with or without
// "tcp://". IPv6 addresses are written in brackets, as in "tcp://[::1]:7410". Port 0 makes a
// listener take a free port. The error is kInvalidArgument, and quotes the text and an example.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text);

// Parses an address to connect to: as parse_endpoint(), or "tls://HOST:PORT",
// "ws://HOST:PORT/PATH", "wss://HOST:PORT/PATH". "http://" and "https://", the viewer's addresses,
// mean "ws://" and "wss://". The default ports of WebSockets are those of HTTP, 80 and 443.
// kStreamPath is appended to an empty path and to one that ends in "/", under which a proxy may
// serve the server.
[[nodiscard]] Result<Endpoint> parse_server_url(std::string_view text);

// Returns whether `host` is this machine: "localhost", 127.0.0.0/8 or ::1.
[[nodiscard]] bool is_this_machine(std::string_view host);

// Returns "tcp://HOST:PORT" or the like, which parse_server_url() accepts.
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

}  // namespace multitetra
