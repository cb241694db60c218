#include "server/http/http_listener.hpp"

#include <algorithm>
#include <utility>

#include "common/net/websocket_transport.hpp"
#include "server/http/detail/http_connection.hpp"
#include "server/transport/message_connection.hpp"

namespace multitetra {
HttpListener::HttpListener(const ServerContext& server, HttpOptions options,
                           std::unique_ptr<RequestHandler> handler)
    : server_(server),
      options_(std::move(options)),
      handler_(std::move(handler)),
      acceptor_(server_.io, options_.listen, "--http"),
      connections_(server_.io,
                   std::min({options_.connection.handshake_timeout, options_.keep_alive_timeout,
                             options_.connection.write_timeout, options_.connection.linger})) {}

std::string HttpListener::url() const {
  return http_url(acceptor_.endpoint(), /*is_secure=*/server_.admission.tls() != nullptr);
}

void HttpListener::open() {
  acceptor_.open([this](tcp::socket socket, const Peer& peer) { accept(std::move(socket), peer); });
  connections_.start();
}

void HttpListener::close(const Error& why) {
  acceptor_.close();
  connections_.close(why);
}

void HttpListener::accept(tcp::socket socket, const Peer& peer) {
  AdmissionControl::AdmissionResult admitted =
      server_.admission.admit("http", peer.address, peer.name);
  if (!admitted.client) return;
  const ConnectionContextPtr client = admitted.client;
  const std::uint64_t id = client->facts().connection;
  auto stream = std::make_unique<ByteStream>(std::move(socket), server_.admission.tls());
  const auto connection = std::make_shared<HttpConnection>(
      std::move(stream), client, std::move(admitted.refusal), *handler_, options_);
  connections_.put(id, connection);
  try {
    connection->start(
        [this, client](std::unique_ptr<ByteStream> taken, HttpRequest request) {
          upgrade(client, std::move(taken), std::move(request));
        },
        [this, id] { connections_.remove(id); });
  } catch (...) {
    connections_.remove(id);
    throw;
  }
}

void HttpListener::upgrade(const ConnectionContextPtr& client, std::unique_ptr<ByteStream> stream,
                           HttpRequest request) {
  client->set_protocol("websocket");
  const std::uint64_t id = client->facts().connection;
  const WebSocketTimes times = {.handshake = options_.connection.handshake_timeout,
                                .idle = options_.idle_timeout};
  const auto connection = std::make_shared<MessageConnection>(
      std::move(stream),
      [request = std::move(request), times](ByteStream& over, TransportOptions options) {
        return accept_web_socket(over, request, times, options);
      },
      client, server_.new_session_runner(client), options_.connection);
  connection->start([this, id] { connections_.remove(id); });
  connections_.put(id, connection);
}

}  // namespace multitetra
