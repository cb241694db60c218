// An address to listen on or connect to: a host and a port, and the transport,
// as users write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultPort = 7410;
inline constexpr std::string_view kStreamPath = "/v1/stream";  // For WebSockets of a gateway.
inline constexpr std::string_view kSubprotocol = "multitetra.v1";

enum class Transport {
  kTcp,              // Frames over TCP: "tcp://".
  kTls,              // Frames over TLS: "tls://".
  kWebSocket,        // "ws://"
  kSecureWebSocket,  // "wss://", over TLS.
};

struct Endpoint {
  std::string host;  // A name or an address; an IPv6 address stands here without brackets.
  std::uint16_t port = kDefaultPort;
  Transport transport = Transport::kTcp;
  // The path of a WebSocket, from its "/" on; empty for the others.
  std::string path = {};

  [[nodiscard]] bool is_web_socket() const {
    return transport == Transport::kWebSocket || transport == Transport::kSecureWebSocket;
  }
  [[nodiscard]] bool is_secure() const {
    return transport == Transport::kTls || transport == Transport::kSecureWebSocket;
  }
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// Parses an address to listen on: "HOST", "HOST:PORT", "PORT" of this machine or one of them behind
// "tcp://"; an IPv6 address is written in brackets, as in "tcp://[::1]:7410". Port 0 is allowed: a
// listener then takes a free one. kInvalidArgument, with the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text);

// Parses an address to connect to: the same, or "tls://HOST:PORT", "ws://HOST:PORT/PATH",
// "wss://HOST:PORT/PATH"; "http://" and "https://", the address of the viewer, are taken as "ws://"
// and "wss://". Without a port WebSockets have those of HTTP, 80 and 443; without a path
// or with one that ends in "/", where a proxy shows the server, kStreamPath follows.
[[nodiscard]] Result<Endpoint> parse_server_url(std::string_view text);

// Whether only this machine is meant: "localhost", 127.0.0.0/8 or ::1.
[[nodiscard]] bool is_this_machine(std::string_view host);

// "tcp://HOST:PORT" and the like, which parse_server_url reads back.
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

}  // namespace multitetra
