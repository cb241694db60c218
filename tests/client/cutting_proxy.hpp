// A proxy between clients and servers that cuts connections at places that a test chooses.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"
#include "common/net/net.hpp"
#include "common/wire/messages.hpp"

namespace multitetra::testing {

// Where a connection is cut: after `messages` messages or `tiles` tiles, whichever comes first.
// Counts messages from the server; Welcome is the first.
struct Cut {
  std::size_t messages = SIZE_MAX;
  std::size_t tiles = SIZE_MAX;
  // Bytes of the next frame that are passed on too, at most all but one.
  std::size_t bytes_of_next = 0;
  // Sends nothing more instead of closing.
  bool stays_open = false;
};

class CuttingProxy {
 public:
  // `cut_of(i)` returns where connection i is cut. Connection i goes to server i or the last one.
  CuttingProxy(std::vector<Endpoint> servers, std::function<Cut(int)> cut_of)
      : servers_(std::move(servers)), cut_of_(std::move(cut_of)), thread_([this] { serve(); }) {}

  ~CuttingProxy() {
    stopping_ = true;
    boost::system::error_code ignored;
    tcp::socket(io_).connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  CuttingProxy(const CuttingProxy&) = delete;
  CuttingProxy& operator=(const CuttingProxy&) = delete;

  [[nodiscard]] Endpoint endpoint() const { return {.host = "127.0.0.1", .port = port_}; }

  // The tiles, messages and connections passed on completely, over all connections.
  [[nodiscard]] std::vector<ContentDigest> tiles() const {
    const std::lock_guard lock(mutex_);
    return tiles_;
  }
  [[nodiscard]] int messages() const {
    const std::lock_guard lock(mutex_);
    return messages_;
  }
  [[nodiscard]] int connections() const {
    const std::lock_guard lock(mutex_);
    return connections_;
  }

 private:
  using error_code = boost::system::error_code;

  void serve() {
    for (int connection = 0;; ++connection) {
      tcp::socket client = acceptor_.accept();
      if (stopping_) return;
      {
        const std::lock_guard lock(mutex_);
        ++connections_;
      }
      const std::size_t i = static_cast<std::size_t>(connection);
      const Endpoint& server = servers_[std::min(i, servers_.size() - 1)];
      tcp::socket upstream(io_);
      upstream.connect({asio::ip::make_address(server.host), server.port});
      std::thread requests([&] { pass_requests(client, upstream); });
      pass_answers(upstream, client, cut_of_(connection));
      // The client closes its side after it has read everything; closing this side earlier could
      // discard data that it has not read.
      requests.join();
    }
  }

  static void pass_requests(tcp::socket& client, tcp::socket& upstream) {
    std::array<char, 4096> bytes{};
    for (error_code error; !error;) {
      const std::size_t size = client.read_some(asio::buffer(bytes), error);
      error_code ignored;
      if (!error) asio::write(upstream, asio::buffer(bytes, size), ignored);
    }
    error_code ignored;
    upstream.shutdown(tcp::socket::shutdown_both, ignored);
  }

  void pass_answers(tcp::socket& upstream, tcp::socket& client, const Cut& cut) {
    FrameReader frames(kMaxServerFrameBytes);
    std::vector<char> bytes(64 * 1024);
    StepBegin begin;
    std::size_t messages = 0;
    std::size_t tiles = 0;
    error_code error;
    while (!error) {
      const auto content = frames.next();
      if (content && *content) {
        const std::string header = frame_header(static_cast<std::uint32_t>((*content)->size()));
        const std::string frame = header + **content;
        if (messages == cut.messages || tiles == cut.tiles) {
          asio::write(client, asio::buffer(frame, std::min(cut.bytes_of_next, frame.size() - 1)),
                      error);
          break;
        }
        const auto message = parse_server_message(**content);
        {
          const std::lock_guard lock(mutex_);
          ++messages_;
          if (const auto* step = std::get_if<StepBegin>(&*message)) begin = *step;
          if (const auto* tile = std::get_if<Tile>(&*message)) {
            tiles_.push_back(begin.tiles[tile->index].digest);
            ++tiles;
          }
        }
        ++messages;
        asio::write(client, asio::buffer(frame), error);
      } else {
        const std::size_t size = upstream.read_some(asio::buffer(bytes), error);
        frames.feed({bytes.data(), size});
      }
    }
    if (!cut.stays_open) client.shutdown(tcp::socket::shutdown_send, error);
  }

  std::vector<Endpoint> servers_;
  std::function<Cut(int)> cut_of_;
  asio::io_context io_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::uint16_t port_ = acceptor_.local_endpoint().port();
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;  // Guards the three members below.
  std::vector<ContentDigest> tiles_;
  int messages_ = 0;
  int connections_ = 0;
  std::thread thread_;
};

}  // namespace multitetra::testing
