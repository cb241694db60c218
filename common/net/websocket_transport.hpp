// Messages over a WebSocket (RFC 6455), each as one binary message. permessage-deflate is off since
// tiles are compressed already.
//
// The only user of Beast's WebSocket, which takes half a minute to compile.
#pragma once

#include <chrono>
#include <memory>

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "common/net/endpoint.hpp"
#include "common/net/message_transport.hpp"

namespace multitetra {

using TransportPtr = std::unique_ptr<MessageTransport>;

// Opens the client's side, after the handshakes of TCP and TLS. Errors are complete sentences:
// kUnavailable if retrying later may help, kInvalidArgument or kUnsupportedVersion if not.
[[nodiscard]] asio::awaitable<Result<TransportPtr>> open_web_socket(ByteStream& stream,
                                                                    Endpoint server,
                                                                    TransportOptions options);

struct WebSocketTimes {
  std::chrono::milliseconds handshake{10'000};
  // Clients that answer no ping for this long are disconnected.
  std::chrono::milliseconds idle{120'000};
};

// Opens the server's side, for a request that passed the checks of server/http/upgrade.hpp.
using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
[[nodiscard]] asio::awaitable<Result<TransportPtr>> accept_web_socket(ByteStream& stream,
                                                                      UpgradeRequest request,
                                                                      WebSocketTimes times,
                                                                      TransportOptions options);

}  // namespace multitetra
