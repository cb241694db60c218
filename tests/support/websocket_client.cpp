#include "tests/support/websocket_client.hpp"

#include <boost/beast/websocket.hpp>

namespace multitetra::testing {

struct WebSocketClient::State {
  asio::io_context io;
  websocket::stream<tcp::socket, false> socket{io};
  websocket::response_type response;
};

WebSocketClient::WebSocketClient(const Endpoint& at, std::string path)
    : state_(std::make_unique<State>()) {
  auto& socket = state_->socket;
  socket.next_layer().connect({asio::ip::make_address(at.host), at.port});
  socket.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
    request.set(boost::beast::http::field::sec_websocket_protocol,
                boost::beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
  }));
  socket.handshake(state_->response, "localhost", path);
  socket.binary(true);
}
WebSocketClient::~WebSocketClient() = default;

void WebSocketClient::send(const ClientMessage& message) {
  state_->socket.write(asio::buffer(serialize(message)));
}

void WebSocketClient::send_as_text(const ClientMessage& message) {
  state_->socket.text(true);
  send(message);
  state_->socket.binary(true);
}

ServerMessage WebSocketClient::receive() {
  std::string content;
  auto buffer = asio::dynamic_buffer(content);
  state_->socket.read(buffer);
  return parse_server_message(content).value();
}

websocket::close_reason WebSocketClient::closed() {
  try {
    for (;;) receive();
  } catch (const boost::system::system_error&) {
    return state_->socket.reason();
  }
}

const HttpClient::Response& WebSocketClient::response() const { return state_->response; }

}  // namespace multitetra::testing
