// A blocking conversation over a WebSocket.
#pragma once

#include <memory>
#include <string>
#include <variant>

#include <gtest/gtest.h>
#include <boost/beast/websocket/rfc6455.hpp>

#include "common/net/endpoint.hpp"
#include "common/wire/messages.hpp"
#include "tests/support/http_client.hpp"

namespace multitetra::testing {

namespace websocket = boost::beast::websocket;

class WebSocketClient {
 public:
  explicit WebSocketClient(const Endpoint& at, std::string path = std::string(kStreamPath));
  ~WebSocketClient();

  void send(const ClientMessage& message);
  // Sends it as a text message, which servers must reject.
  void send_as_text(const ClientMessage& message);
  ServerMessage receive();
  template <typename M>
  M receive_a() {
    ServerMessage message = receive();
    if (auto* wanted = std::get_if<M>(&message)) return std::move(*wanted);
    ADD_FAILURE() << "another message: alternative " << message.index();
    return {};
  }
  // Returns the reason with which the WebSocket is closed next.
  websocket::close_reason closed();
  [[nodiscard]] const HttpClient::Response& response() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multitetra::testing
