// Where a server listens and a client connects: a host and a port, as users write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultPort = 7410;

struct Endpoint {
  std::string host;  // A name or an address; an IPv6 address stands here without brackets.
  std::uint16_t port = kDefaultPort;

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// "HOST", "HOST:PORT" or either behind "tcp://"; an IPv6 address is written in brackets, as in
// "tcp://[::1]:7410". Port 0 is allowed: a listener then takes a free one. kInvalidArgument, with
// the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text);

// "tcp://HOST:PORT", which parse_endpoint reads back.
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

}  // namespace multitetra
