// Accepts connections on one address; errors of one do not affect others.
#pragma once

#include <functional>
#include <string>

#include "common/base/exit_codes.hpp"
#include "common/net/endpoint.hpp"
#include "common/net/net.hpp"

namespace multitetra {

// The other end of a connection.
struct Peer {
  std::string address;  // Without port.
  std::string name;     // With port, for the log.
};

class Acceptor {
 public:
  // Handles a connection. May throw: the connection is dropped then, and others are
  // accepted.
  using OnAccept = std::function<void(tcp::socket socket, const Peer& peer)>;

  // Binds and listens. Throws AddressError that names the address, and `option`, where it can be
  // changed, when that fails. Must outlive the io_context's last handler once it was opened.
  Acceptor(asio::io_context& io, const Endpoint& at, const char* option);

  // With the real port.
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }
  void open(OnAccept on_accept);
  void close();

 private:
  asio::awaitable<void> accept(OnAccept on_accept);

  tcp::acceptor acceptor_;
  Endpoint endpoint_;
  asio::steady_timer retry_;
  bool is_closed_ = false;
};

}  // namespace multitetra
