// Serves conversations in frames over TCP or TLS.
#pragma once

#include "server/transport/acceptor.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/connection_table.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

class TcpListener : public Listener {
 public:
  // Binds and listens. Throws AddressError, which names the address, if that fails.
  TcpListener(const ServerContext& server, TcpListenerOptions options);

  [[nodiscard]] Endpoint endpoint() const override { return acceptor_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void accept(tcp::socket socket, const Peer& peer);

  ServerContext server_;
  TcpListenerOptions options_;
  Acceptor acceptor_;
  ConnectionTable connections_;
};

}  // namespace multitetra
