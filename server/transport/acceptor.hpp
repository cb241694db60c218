// Accepts connections on one address. An error of one connection does not affect others.
#pragma once

#include <functional>
#include <string>

#include "common/base/exit_codes.hpp"
#include "common/net/endpoint.hpp"
#include "common/net/net.hpp"

namespace multitetra {

// The other end of a connection.
struct Peer {
  std::string address;  // Address without port.
  std::string name;     // Address and port, for the log.
};

class Acceptor {
 public:
  // Handles a connection. If it throws, only that connection is dropped.
  using OnAccept = std::function<void(tcp::socket socket, const Peer& peer)>;

  // Binds and listens. On failure throws AddressError, which names the address and the `option`
  // that sets it. Once opened, must outlive the io_context's last handler.
  Acceptor(asio::io_context& io, const Endpoint& at, const char* option);

  // Has the actual port.
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
