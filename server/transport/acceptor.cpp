#include "server/transport/acceptor.hpp"

#include <stdexcept>
#include <utility>

#include "common/net/coroutines.hpp"
#include "server/operations/log.hpp"

namespace multitetra {

namespace {

Peer peer_of(const tcp::socket& socket) {
  error_code error;
  const tcp::endpoint end = socket.remote_endpoint(error);
  if (error) return {.address = "unknown client", .name = "unknown client"};
  std::string address = end.address().to_string();
  std::string name = address + ":" + std::to_string(end.port());
  return {.address = std::move(address), .name = std::move(name)};
}

tcp::acceptor listening(asio::io_context& io, const Endpoint& at, const char* option) {
  try {
    tcp::resolver resolver(io);
    const auto found = resolver.resolve(at.host, std::to_string(at.port), tcp::resolver::passive);
    return tcp::acceptor(io, *found.begin(), /*reuse_addr=*/true);
  } catch (const boost::system::system_error& error) {
    const std::string address = to_string(at).substr(std::string_view("tcp://").size());
    throw AddressError("Cannot listen on " + address + " (" + option +
                       "): " + error.code().message() +
                       ". Is another server running there? Choose another port with " + option +
                       " HOST:PORT, port 0 for a free one, or " + option + " off.");
  }
}

}  // namespace

Acceptor::Acceptor(asio::io_context& io, const Endpoint& at, const char* option)
    : acceptor_(listening(io, at, option)), endpoint_(at), retry_(io) {
  endpoint_.port = acceptor_.local_endpoint().port();
}

void Acceptor::open(OnAccept on_accept) {
  spawn(acceptor_.get_executor(), [this, on_accept = std::move(on_accept)]() mutable {
    return accept(std::move(on_accept));
  });
}

void Acceptor::close() {
  is_closed_ = true;
  error_code ignored;
  acceptor_.close(ignored);
  retry_.cancel();
}

asio::awaitable<void> Acceptor::accept(OnAccept on_accept) {
  while (!is_closed_) {
    error_code error;
    tcp::socket socket = co_await acceptor_.async_accept(use_error(error));
    if (is_closed_) break;
    if (error) {
      // Most likely out of file descriptors: retry, as ending connections release some.
      log_line(LogLevel::kWarning, "cannot accept a connection: " + error.message(), {});
      retry_.expires_after(std::chrono::milliseconds(100));
      co_await wait_on(retry_);
      continue;
    }
    const Peer peer = peer_of(socket);
    try {
      on_accept(std::move(socket), peer);
    } catch (const std::exception& failure) {
      log_line(LogLevel::kError,
               std::string("the connection could not be served: ") + failure.what(),
               {{"peer", peer.name}});
    }
  }
}

}  // namespace multitetra
