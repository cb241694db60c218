// Messages over a WebSocket (RFC 6455): a binary message is one message of the conversation.
// Without permessage-deflate, since tiles are compressed already.
//
// The one place of Beast's WebSocket, which takes half a minute to compile.
#pragma once

#include <chrono>
#include <memory>

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "common/net/endpoint.hpp"
#include "common/net/message_transport.hpp"

namespace multitetra {

using TransportPtr = std::unique_ptr<MessageTransport>;

// As the client, behind the handshakes of TCP and TLS. An error of open() is a whole sentence:
// kUnavailable when the server may be there later, kInvalidArgument or kUnsupportedVersion when
// trying again is no use.
[[nodiscard]] asio::awaitable<Result<TransportPtr>> open_web_socket(ByteStream& stream,
                                                                    Endpoint server,
                                                                    TransportOptions options);

struct WebSocketTimes {
  std::chrono::milliseconds handshake{10'000};
  // A client that answers no ping for so long is disconnected.
  std::chrono::milliseconds idle{120'000};
};

// As the server, for a request that passed the checks of server/http/upgrade.hpp.
using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
[[nodiscard]] asio::awaitable<Result<TransportPtr>> accept_web_socket(ByteStream& stream,
                                                                      UpgradeRequest request,
                                                                      WebSocketTimes times,
                                                                      TransportOptions options);

}  // namespace multitetra
