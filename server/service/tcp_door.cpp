#include "server/service/tcp_door.hpp"

#include <utility>

namespace multitetra {

TcpDoor::TcpDoor(const House& house, TcpDoorOptions options)
    : house_(house), options_(std::move(options)), listener_(house.io, options_.listen) {}

std::string TcpDoor::url() const {
  Endpoint endpoint = listener_.endpoint();
  if (house_.keeper.tls()) endpoint.transport = Transport::kTls;
  return to_string(endpoint);
}

void TcpDoor::open() {
  listener_.open(
      [this](tcp::socket socket, const Peer& peer) { welcome(std::move(socket), peer); });
}

void TcpDoor::close(const Error& why) {
  listener_.close();
  for (const auto& [id, connection] : connections_) connection->end(why);
}

void TcpDoor::welcome(tcp::socket socket, const Peer& peer) {
  const Doorkeeper::Admitted admitted = house_.keeper.admit("tcp", peer.address, peer.name);
  if (!admitted.guest) return;
  const std::uint64_t id = admitted.guest->facts().connection;
  const auto connection =
      std::make_shared<Connection>(std::move(socket), house_.keeper.tls(), admitted.guest,
                                   house_.new_dialogue(admitted.guest), options_.connection);
  connections_.emplace(id, connection);
  try {
    connection->start([this, id] { connections_.erase(id); });
  } catch (...) {
    connections_.erase(id);
    throw;
  }
  if (admitted.refusal) connection->end(*admitted.refusal);
}

}  // namespace multitetra
