#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"
#include "common/net/net.hpp"
#include "common/wire/messages.hpp"
#include "tests/support/fake_steps.hpp"

namespace multitetra::testing {

// A server whose messages are the values of a function, called in its thread; none for nullopt.
class StubServer {
 public:
  using Answer = std::function<std::optional<ServerMessage>(const ClientMessage&)>;

  explicit StubServer(Answer answer)
      : answer_(std::move(answer)), acceptor_(io_, {asio::ip::make_address("127.0.0.1"), 0}) {
    asio::co_spawn(
        io_, [this] { return accept(); }, asio::detached);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~StubServer() {
    io_.stop();
    thread_.join();
  }
  [[nodiscard]] Endpoint endpoint() const {
    return {.host = "127.0.0.1", .port = acceptor_.local_endpoint().port()};
  }

 private:
  asio::awaitable<void> accept() {
    for (;;) {
      auto socket =
          std::make_shared<tcp::socket>(co_await acceptor_.async_accept(asio::use_awaitable));
      asio::co_spawn(
          io_, [this, socket] { return talk(socket); }, asio::detached);
    }
  }
  asio::awaitable<void> talk(std::shared_ptr<tcp::socket> socket) {
    FrameReader frames(kMaxClientFrameBytes);
    std::array<char, 4096> buffer{};
    for (;;) {
      const auto content = frames.next();
      if (!content) co_return;
      if (*content) {
        const auto message = parse_client_message(**content);
        const auto reply = message ? answer_(*message) : std::nullopt;
        if (!reply) continue;
        std::string answer = serialize(*reply);
        answer = frame_header(static_cast<std::uint32_t>(answer.size())) + answer;
        co_await asio::async_write(*socket, asio::buffer(answer), asio::use_awaitable);
      } else {
        const std::size_t size =
            co_await socket->async_read_some(asio::buffer(buffer), asio::use_awaitable);
        frames.feed({buffer.data(), size});
      }
    }
  }

  Answer answer_;
  asio::io_context io_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

// Sends Welcome and its list of datasets, and nothing else, like a process that hangs during work.
class HangingServer : public StubServer {
 public:
  HangingServer() : StubServer(&answer) {}

 private:
  static std::optional<ServerMessage> answer(const ClientMessage& message) {
    if (std::holds_alternative<Hello>(message)) return Welcome{};
    const auto* list = std::get_if<ListDatasets>(&message);
    if (!list) return std::nullopt;
    return DatasetList{.request_id = list->request_id,
                       .datasets = {FakeSteps("octahedron").info()}};
  }
};

}  // namespace multitetra::testing
