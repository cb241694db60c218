// The connections of one listener, with one timer for all their time limits.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>

#include "common/net/net.hpp"
#include "server/transport/connection.hpp"

namespace multitetra {

class ConnectionTable {
 public:
  // `shortest` is the shortest time limit of the connections. Once started, must outlive the
  // io_context's last handler.
  ConnectionTable(asio::io_context& io, std::chrono::milliseconds shortest);

  // Runs the timer until the table is closed and all connections have ended.
  void start();
  // Adds a connection under a unique id. After a protocol upgrade the new connection replaces the
  // old one.
  void put(std::uint64_t id, ConnectionPtr connection);
  void remove(std::uint64_t id);
  // Ends all connections, including any added later.
  void close(const Error& why);

 private:
  asio::awaitable<void> enforce_limits();

  std::chrono::milliseconds pause_;
  asio::steady_timer timer_;
  std::optional<Error> closed_;
  std::map<std::uint64_t, ConnectionPtr> connections_;
};

}  // namespace multitetra
