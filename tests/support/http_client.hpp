// A blocking HTTP connection for tests.
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
  // Receives the next response; `to_head`: it has no body, whatever its header says.
  Response receive(bool to_head = false);
  Response request(std::string_view method, std::string_view target, std::string_view fields = {});
  Response get(std::string_view target, std::string_view fields = {}) {
    return request("GET", target, fields);
  }
  // Returns everything until the server closes the connection.
  std::string rest();
  [[nodiscard]] tcp::socket& socket() { return socket_; }

 private:
  asio::io_context io_;
  tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
};

// Returns the error code of a JSON reply.
std::string error_code_of(const HttpClient::Response& response);

// The header fields of a WebSocket upgrade, without the subprotocol.
inline constexpr const char* kUpgradeFields =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

}  // namespace multitetra::testing
