// A link of so many bits a second between a client and a server of this machine: what the server
// sends waits its turn, and the server's socket shows that it waits, as over a real link.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

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
    to_server_.set_option(asio::socket_base::receive_buffer_size(
        std::max(kMinBytesInFlight, static_cast<int>(2 * bytes_per_second * kTick))));
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
  static constexpr int kMinBytesInFlight = 8 * 1024;
  static constexpr std::size_t kMinPacket = 1400;
  static constexpr double kTick = 1e-3;  // Seconds. Sleeping is not exact to much less.

  static Clock::duration duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  void run() {
    error_code error;
    acceptor_.accept(to_client_, error);
    if (error) return;
    to_client_.set_option(tcp::no_delay(true));
    const std::jthread requests([this] { pass(to_client_, to_server_, /*is_shaped=*/false); });
    pass(to_server_, to_client_, /*is_shaped=*/true);
  }

  void pass(tcp::socket& from, tcp::socket& to, bool is_shaped) const {
    const double tick_bytes = std::min(bytes_per_second_ * kTick / 2, 1e6);
    std::vector<char> bytes(std::max(kMinPacket, static_cast<std::size_t>(tick_bytes)));
    error_code error;
    Clock::time_point free_at = Clock::now();
    while (!error) {
      const std::size_t size = from.read_some(asio::buffer(bytes), error);
      if (error) break;
      if (is_shaped) {
        const std::chrono::duration<double> takes(static_cast<double>(size) / bytes_per_second_);
        // What was slept too long is made up for.
        free_at = std::max(free_at, Clock::now() - duration(kTick)) + duration(takes.count());
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
