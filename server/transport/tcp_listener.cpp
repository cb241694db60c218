#include "server/transport/tcp_listener.hpp"

#include <algorithm>
#include <utility>

#include "server/transport/message_connection.hpp"

namespace multitetra {
namespace {

asio::awaitable<Result<std::unique_ptr<MessageTransport>>> open_frames(ByteStream& stream,
                                                                       TransportOptions options) {
  const error_code error = co_await stream.handshake_as_server();
  if (error) co_return fail(ErrorCode::kUnavailable, "no TLS: " + error.message());
  co_return frames_over(stream, options);
}

}  // namespace

TcpListener::TcpListener(const ServerContext& server, TcpListenerOptions options)
    : server_(server),
      options_(std::move(options)),
      acceptor_(server.io, options_.listen, "--tcp"),
      connections_(server.io,
                   std::min({options_.connection.handshake_timeout,
                             options_.connection.write_timeout, options_.connection.linger})) {}

std::string TcpListener::url() const {
  Endpoint endpoint = acceptor_.endpoint();
  if (server_.admission.tls()) endpoint.transport = Transport::kTls;
  return to_string(endpoint);
}

void TcpListener::open() {
  acceptor_.open([this](tcp::socket socket, const Peer& peer) { accept(std::move(socket), peer); });
  connections_.start();
}

void TcpListener::close(const Error& why) {
  acceptor_.close();
  connections_.close(why);
}

void TcpListener::accept(tcp::socket socket, const Peer& peer) {
  const AdmissionControl::AdmissionResult admitted =
      server_.admission.admit("tcp", peer.address, peer.name);
  if (!admitted.client) return;
  const std::uint64_t id = admitted.client->facts().connection;
  auto stream = std::make_unique<ByteStream>(std::move(socket), server_.admission.tls());
  const auto connection = std::make_shared<MessageConnection>(
      std::move(stream), open_frames, admitted.client, server_.new_session_runner(admitted.client),
      options_.connection);
  connections_.put(id, connection);
  try {
    connection->start([this, id] { connections_.remove(id); });
  } catch (...) {
    connections_.remove(id);
    throw;
  }
  if (admitted.refusal) connection->end(*admitted.refusal);
}

}  // namespace multitetra
