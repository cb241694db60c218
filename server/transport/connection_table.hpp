// The connections that one listener holds, and the one timer by which they keep their limits.
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
  // `shortest` is the shortest time that a connection limits. Must outlive the io_context's last
  // handler once it was started.
  ConnectionTable(asio::io_context& io, std::chrono::milliseconds shortest);

  // Keeps time until it is closed and all connections have ended.
  void start();
  // By a number of its own; a connection that speaks something else from now on takes the place of
  // the one before.
  void put(std::uint64_t id, ConnectionPtr connection);
  void remove(std::uint64_t id);
  // Ends all open connections, and later ones.
  void close(const Error& why);

 private:
  asio::awaitable<void> keep_time();

  std::chrono::milliseconds pause_;
  asio::steady_timer timer_;
  std::optional<Error> closed_;
  std::map<std::uint64_t, ConnectionPtr> connections_;
};

}  // namespace multitetra
