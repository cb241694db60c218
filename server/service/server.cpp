#include "server/service/server.hpp"

#include <algorithm>
#include <csignal>
#include <map>
#include <stdexcept>

#include <spdlog/spdlog.h>

namespace multitetra {

using boost::system::error_code;

namespace {

std::string peer_name(const tcp::socket& socket) {
  error_code error;
  const tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) return "unknown client";
  return peer.address().to_string() + ":" + std::to_string(peer.port());
}

tcp::acceptor listening(asio::io_context& io, const Endpoint& at) {
  try {
    tcp::resolver resolver(io);
    const auto found = resolver.resolve(at.host, std::to_string(at.port), tcp::resolver::passive);
    return tcp::acceptor(io, *found.begin(), /*reuse_addr=*/true);
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("Cannot listen on " + to_string(at) + ": " + error.code().message() +
                             ". Is another server running there? Choose another port, or port 0 "
                             "for a free one.");
  }
}

}  // namespace

// Members of one thread: everything but stop() runs in run().
class Server::Listener {
 public:
  Listener(CataloguePtr catalogue, ServerOptions options)
      : catalogue_(std::move(catalogue)),
        options_(std::move(options)),
        io_(/*concurrency_hint=*/1),
        workers_(options_.workers),
        acceptor_(listening(io_, options_.listen)),
        signals_(io_),
        retry_(io_) {
    options_.connection.max_message_bytes = options_.session.max_message_bytes;
  }
  ~Listener() { workers_.join(); }

  [[nodiscard]] Endpoint endpoint() const { return {.host = options_.listen.host, .port = port_}; }

  void run() {
    if (options_.stop_on_signals) watch_signals();
    asio::co_spawn(
        io_, [this] { return accept(); }, asio::detached);
    io_.run();
    workers_.join();
  }

  void stop() {
    asio::post(io_, [this] {
      if (is_stopping_) return;
      is_stopping_ = true;
      spdlog::info("stopping, {} connections", connections_.size());
      error_code ignored;
      acceptor_.close(ignored);
      signals_.cancel(ignored);
      retry_.cancel();
      for (const auto& [id, connection] : connections_) {
        connection->end({ErrorCode::kUnavailable, "The server stops; connect again later."});
      }
    });
  }

 private:
  void watch_signals() {
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    signals_.async_wait([this](error_code cancelled, int) {
      if (!cancelled) stop();
    });
  }

  asio::awaitable<void> accept() {
    while (!is_stopping_) {
      error_code error;
      tcp::socket socket = co_await acceptor_.async_accept(use_error(error));
      if (is_stopping_) break;
      if (error) {
        // Out of descriptors, most likely: connections that end make room again.
        spdlog::warn("cannot accept a connection: {}", error.message());
        retry_.expires_after(std::chrono::milliseconds(100));
        co_await retry_.async_wait(use_error(error));
      } else {
        welcome(std::move(socket));
      }
    }
  }

  // Trouble with one client, such as no memory left for it, must not end the accepting of others.
  void welcome(tcp::socket socket) {
    const std::uint64_t id = next_id_++;
    try {
      start_connection(id, std::move(socket));
    } catch (const std::exception& trouble) {
      connections_.erase(id);
      spdlog::error("a connection could not be served: {}", trouble.what());
    }
  }

  void start_connection(std::uint64_t id, tcp::socket socket) {
    const std::string peer = peer_name(socket);
    const auto conversation = std::make_shared<Conversation>(
        io_.get_executor(), workers_, Session(catalogue_, options_.session), peer);
    const auto connection =
        std::make_shared<Connection>(std::move(socket), conversation, options_.connection);
    const bool is_full = connections_.size() >= options_.max_connections;
    spdlog::info("{}: connected", peer);
    connections_.emplace(id, connection);
    connection->start([this, id, peer] {
      connections_.erase(id);
      spdlog::info("{}: disconnected", peer);
    });
    if (is_full) {
      connection->end({ErrorCode::kUnavailable, "The server has its " +
                                                    std::to_string(options_.max_connections) +
                                                    " connections; try again later."});
    }
  }

  CataloguePtr catalogue_;
  ServerOptions options_;
  asio::io_context io_;
  Workers workers_;
  tcp::acceptor acceptor_;
  const std::uint16_t port_ = acceptor_.local_endpoint().port();
  asio::signal_set signals_;
  asio::steady_timer retry_;
  bool is_stopping_ = false;
  std::uint64_t next_id_ = 0;
  std::map<std::uint64_t, std::shared_ptr<Connection>> connections_;
};

Server::Server(CataloguePtr catalogue, ServerOptions options)
    : listener_(std::make_unique<Listener>(std::move(catalogue), std::move(options))) {}
Server::~Server() = default;

Endpoint Server::endpoint() const { return listener_->endpoint(); }
void Server::run() { listener_->run(); }
void Server::stop() { listener_->stop(); }

}  // namespace multitetra
