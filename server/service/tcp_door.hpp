// Conversations in frames over TCP, or TLS over TCP.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "server/service/connection.hpp"
#include "server/service/door.hpp"
#include "server/service/listener.hpp"

namespace multitetra {

struct TcpDoorOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultPort};  // Port 0: the system chooses one.
  ConnectionOptions connection = {};
};

class TcpDoor : public Door {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  TcpDoor(const House& house, TcpDoorOptions options);

  [[nodiscard]] Endpoint endpoint() const override { return listener_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void welcome(tcp::socket socket, const Peer& peer);

  House house_;
  TcpDoorOptions options_;
  Listener listener_;
  std::map<std::uint64_t, std::shared_ptr<Connection>> connections_;
};

}  // namespace multitetra
