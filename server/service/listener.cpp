#include "server/service/listener.hpp"

#include <stdexcept>
#include <utility>

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

Listener::Listener(asio::io_context& io, const Endpoint& at)
    : acceptor_(listening(io, at)), endpoint_(at), retry_(io) {
  endpoint_.port = acceptor_.local_endpoint().port();
}

void Listener::open(Welcome welcome) {
  asio::co_spawn(
      acceptor_.get_executor(),
      [this, welcome = std::move(welcome)]() mutable { return accept(std::move(welcome)); },
      asio::detached);
}

void Listener::close() {
  is_closed_ = true;
  error_code ignored;
  acceptor_.close(ignored);
  retry_.cancel();
}

asio::awaitable<void> Listener::accept(Welcome welcome) {
  while (!is_closed_) {
    error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(use_error(error));
    if (is_closed_) break;
    if (error) {
      // Out of descriptors, most likely: connections that end make room again.
      spdlog::warn("cannot accept a connection: {}", error.message());
      retry_.expires_after(std::chrono::milliseconds(100));
      co_await retry_.async_wait(use_error(error));
      continue;
    }
    const std::string peer = peer_name(socket);
    try {
      welcome(std::move(socket), peer);
    } catch (const std::exception& trouble) {
      spdlog::error("{}: the connection could not be served: {}", peer, trouble.what());
    }
  }
}

}  // namespace multitetra
