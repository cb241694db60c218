// Conversations in frames over TCP, or TLS over TCP.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "server/transport/acceptor.hpp"
#include "server/transport/connection.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

struct TcpListenerOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  ConnectionOptions connection = {};
};

class TcpListener : public Listener {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  TcpListener(const ServerContext& server, TcpListenerOptions options);

  [[nodiscard]] Endpoint endpoint() const override { return acceptor_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void welcome(tcp::socket socket, const Peer& peer);

  ServerContext server_;
  TcpListenerOptions options_;
  Acceptor acceptor_;
  std::map<std::uint64_t, std::shared_ptr<Connection>> connections_;
};

}  // namespace multitetra
