#include "server/transport/tcp_listener.hpp"

#include <utility>

namespace multitetra {

TcpListener::TcpListener(const ServerContext& server, TcpListenerOptions options)
    : server_(server), options_(std::move(options)), acceptor_(server.io, options_.listen) {}

std::string TcpListener::url() const {
  Endpoint endpoint = acceptor_.endpoint();
  if (server_.admission.tls()) endpoint.transport = Transport::kTls;
  return to_string(endpoint);
}

void TcpListener::open() {
  acceptor_.open(
      [this](tcp::socket socket, const Peer& peer) { welcome(std::move(socket), peer); });
}

void TcpListener::close(const Error& why) {
  acceptor_.close();
  for (const auto& [id, connection] : connections_) connection->end(why);
}

void TcpListener::welcome(tcp::socket socket, const Peer& peer) {
  const AdmissionControl::Admitted admitted =
      server_.admission.admit("tcp", peer.address, peer.name);
  if (!admitted.client) return;
  const std::uint64_t id = admitted.client->facts().connection;
  const auto connection =
      std::make_shared<Connection>(std::move(socket), server_.admission.tls(), admitted.client,
                                   server_.new_session(admitted.client), options_.connection);
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
