// A link of so many bits a second between a client and a server of this machine: what the server
// sends waits its turn, and the server's socket shows that it waits, as over a real link.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <thread>

#include "common/net/endpoint.hpp"
#include "common/net/net.hpp"

namespace multitetra {

// Takes one connection.
class ShapedLink {
 public:
  ShapedLink(const Endpoint& server, double bytes_per_second)
      : to_server_(io_), to_client_(io_), bytes_per_second_(bytes_per_second) {
    to_server_.open(tcp::v4());
    // What a link has under way is little.
    to_server_.set_option(asio::socket_base::receive_buffer_size(kUnderWay));
    to_server_.connect({asio::ip::make_address(server.host), server.port});
    thread_ = std::jthread([this] { run(); });
  }
  ~ShapedLink() {
    error_code ignored;
    acceptor_.close(ignored);
    to_server_.shutdown(tcp::socket::shutdown_both, ignored);
    to_client_.shutdown(tcp::socket::shutdown_both, ignored);
  }
  ShapedLink(const ShapedLink&) = delete;
  ShapedLink& operator=(const ShapedLink&) = delete;

  [[nodiscard]] Endpoint endpoint() const {
    return {.host = "127.0.0.1", .port = acceptor_.local_endpoint().port()};
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kUnderWay = 8 * 1024;
  static constexpr std::size_t kPacket = 1400;

  void run() {
    error_code error;
    acceptor_.accept(to_client_, error);
    if (error) return;
    to_client_.set_option(tcp::no_delay(true));
    const std::jthread requests([this] { pass(to_client_, to_server_, /*is_shaped=*/false); });
    pass(to_server_, to_client_, /*is_shaped=*/true);
  }

  void pass(tcp::socket& from, tcp::socket& to, bool is_shaped) const {
    std::array<char, kPacket> bytes{};
    error_code error;
    Clock::time_point free_at = Clock::now();
    while (!error) {
      const std::size_t size = from.read_some(asio::buffer(bytes), error);
      if (error) break;
      if (is_shaped) {
        const std::chrono::duration<double> takes(static_cast<double>(size) / bytes_per_second_);
        free_at =
            std::max(free_at, Clock::now()) + std::chrono::duration_cast<Clock::duration>(takes);
        std::this_thread::sleep_until(free_at);
      }
      asio::write(to, asio::buffer(bytes, size), error);
    }
    error_code ignored;
    to.shutdown(tcp::socket::shutdown_send, ignored);
  }

  asio::io_context io_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  tcp::socket to_server_;
  tcp::socket to_client_;
  double bytes_per_second_;
  std::jthread thread_;
};

}  // namespace multitetra
