// A connection over which tests speak HTTP, blocking.
#pragma once

#include <string>
#include <string_view>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include "common/net/endpoint.hpp"
#include "common/net/net.hpp"

namespace multitetra::testing {

class HttpClient {
 public:
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  explicit HttpClient(const Endpoint& at);

  void send(std::string_view bytes);
  // The next response; `to_head` if it has no body whatever its header says.
  Response receive(bool to_head = false);
  Response ask(std::string_view method, std::string_view target, std::string_view fields = {});
  Response get(std::string_view target, std::string_view fields = {}) {
    return ask("GET", target, fields);
  }
  // Everything until the server hangs up.
  std::string rest();
  [[nodiscard]] tcp::socket& socket() { return socket_; }

 private:
  asio::io_context io_;
  tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
};

// The word by which an answer in JSON names its error.
std::string error_code_of(const HttpClient::Response& response);

// The fields of a request for a WebSocket, but for its subprotocol.
inline constexpr const char* kUpgradeFields =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

}  // namespace multitetra::testing
