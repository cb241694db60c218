#include "common/net/websocket_transport.hpp"

#include <array>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

using namespace std::chrono_literals;
namespace http = boost::beast::http;

UpgradeRequest upgrade() {
  UpgradeRequest request(http::verb::get, "/", 11);
  request.set(http::field::host, "localhost");
  request.set(http::field::connection, "upgrade");
  request.set(http::field::upgrade, "websocket");
  request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
  request.set(http::field::sec_websocket_version, "13");
  request.set(http::field::sec_websocket_protocol, std::string(kSubprotocol));
  return request;
}

asio::awaitable<void> pause(std::chrono::milliseconds time) {
  asio::steady_timer timer(co_await asio::this_coro::executor, time);
  co_await timer.async_wait(asio::use_awaitable);
}

// Answers the close frame, but leaves the connection open.
asio::awaitable<void> answer_close(tcp::socket& client) {
  std::string received;
  for (std::array<char, 1024> bytes{}; received.find('\x88') == std::string::npos;) {
    const std::size_t size =
        co_await client.async_read_some(asio::buffer(bytes), asio::use_awaitable);
    received.append(bytes.data(), size);
  }
  const std::string close("\x88\x82\0\0\0\0\x03\xe8", 8);
  co_await asio::async_write(client, asio::buffer(close), asio::use_awaitable);
}

TEST(WebSocketTransport, EndsReceivingWhileAClientDelaysTheEndOfTheConnection) {
  asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  tcp::socket client(io);
  client.connect(acceptor.local_endpoint());
  ByteStream stream(acceptor.accept());
  bool is_closed = false;
  std::optional<Result<std::string>> received;
  const auto serve = [&]() -> asio::awaitable<void> {
    auto transport =
        co_await accept_web_socket(stream, upgrade(), {.handshake = 300ms}, TransportOptions());
    if (!transport) co_return;
    const auto close = [&]() -> asio::awaitable<void> {
      co_await (*transport)->close_gracefully();
      is_closed = true;
    };
    asio::co_spawn(io, close(), asio::detached);
    co_await pause(100ms);
    received = co_await (*transport)->receive();
    while (!is_closed) co_await pause(10ms);
  };
  asio::co_spawn(io, serve(), asio::detached);
  asio::co_spawn(io, answer_close(client), asio::detached);
  io.run_for(10s);
  EXPECT_TRUE(is_closed);
  ASSERT_TRUE(received);
  EXPECT_FALSE(*received);
}

}  // namespace
}  // namespace multitetra
