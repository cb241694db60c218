// WebSocket (RFC 6455) over a StreamSocket: the one file that includes Beast's WebSocket.
//
//   WebSocket socket(stream);                   // The stream outlives it.
//   co_await socket.async_read(buffer, use_error(error));
//
// A binary message is one message of the conversation.
#pragma once

#include <utility>

#include "common/net/endpoint.hpp"
#include "common/net/stream_socket.hpp"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace multitetra {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

// Beast finds this by its argument when a WebSocket has been closed.
template <typename Handler>
void async_teardown(beast::role_type role, StreamSocket& stream, Handler&& handler) {
  if (stream.is_tls()) {
    stream.async_shutdown(std::forward<Handler>(handler));
  } else {
    websocket::async_teardown(role, stream.socket(), std::forward<Handler>(handler));
  }
}

// The same when a limit on time is exceeded.
inline void beast_close_socket(StreamSocket& stream) { stream.close(); }

// Without permessage-deflate: tiles are compressed already.
using WebSocket = websocket::stream<StreamSocket&, /*deflateSupported=*/false>;

}  // namespace multitetra
