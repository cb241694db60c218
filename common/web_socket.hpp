// The one file that includes Beast's WebSockets, over a StreamSocket.
#pragma once

#include <utility>

#include "common/stream_socket.hpp"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace multitetra {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

// How Beast ends the byte stream under a WebSocket, found by the type of the stream: what was
// written is sent, and nothing is waited for, because the WebSockets' own goodbye came before.
template <typename Handler>
void async_teardown(beast::role_type, StreamSocket& stream, Handler&& handler) {
  boost::system::error_code error;
  stream.socket().shutdown(tcp::socket::shutdown_send, error);
  asio::post(stream.get_executor(),
             beast::bind_front_handler(std::forward<Handler>(handler), error));
}

inline void beast_close_socket(StreamSocket& stream) { stream.close(); }

}  // namespace multitetra
