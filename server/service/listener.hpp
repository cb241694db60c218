// Accepts connections on one address, whatever trouble single ones make.
#pragma once

#include <functional>
#include <string>

#include "common/endpoint.hpp"
#include "common/net.hpp"

namespace multitetra {

class Listener {
 public:
  // What to do with a connection; `peer` is its address and port. May throw: the connection is
  // dropped then, and others are accepted.
  using Welcome = std::function<void(tcp::socket socket, const std::string& peer)>;

  // Binds and listens. Throws std::runtime_error that names the address when that fails. Must
  // outlive the io_context's last handler once it was opened.
  Listener(asio::io_context& io, const Endpoint& at);

  // With the real port.
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }
  void open(Welcome welcome);
  void close();

 private:
  asio::awaitable<void> accept(Welcome welcome);

  tcp::acceptor acceptor_;
  Endpoint endpoint_;
  asio::steady_timer retry_;
  bool is_closed_ = false;
};

}  // namespace multitetra
