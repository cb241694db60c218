#include "server/service/tcp_door.hpp"

#include <string>
#include <utility>

#include <spdlog/spdlog.h>

namespace multitetra {

TcpDoor::TcpDoor(const House& house, TcpDoorOptions options)
    : house_(house), options_(std::move(options)), listener_(house.io, options_.listen) {}

void TcpDoor::open() {
  listener_.open(
      [this](tcp::socket socket, const std::string& peer) { welcome(std::move(socket), peer); });
}

void TcpDoor::close(const Error& why) {
  listener_.close();
  for (const auto& [id, connection] : connections_) connection->end(why);
}

void TcpDoor::welcome(tcp::socket socket, const std::string& peer) {
  const bool is_full = connections_.size() >= options_.max_connections;
  const std::uint64_t id = next_id_++;
  const auto connection =
      std::make_shared<Connection>(std::move(socket), next_context(options_.tls),
                                   house_.new_dialogue(peer), options_.connection);
  spdlog::info("{}: connected", peer);
  connections_.emplace(id, connection);
  try {
    connection->start([this, id, peer] {
      connections_.erase(id);
      spdlog::info("{}: disconnected", peer);
    });
  } catch (...) {
    connections_.erase(id);
    throw;
  }
  if (is_full) {
    connection->end({ErrorCode::kUnavailable, "The server has its " +
                                                  std::to_string(options_.max_connections) +
                                                  " connections; try again later."});
  }
}

}  // namespace multitetra
