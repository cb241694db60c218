// A server on a free local port, running in its own thread.
#pragma once

#include <thread>

#include <gtest/gtest.h>

#include "client/library/message_socket.hpp"
#include "server/operations/log.hpp"
#include "server/transport/server.hpp"

namespace multitetra::testing {

class RunningServer {
 public:
  explicit RunningServer(CataloguePtr catalogue, ServerOptions options = {})
      : server_(std::move(catalogue), on_a_free_port(std::move(options))),
        thread_([this] { server_.run(); }) {}
  ~RunningServer() { stop(); }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  void stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  // Waits until it has stopped by itself.
  void wait() {
    if (thread_.joinable()) thread_.join();
  }
  void drain() { server_.drain(); }
  void reload() { server_.reload(); }
  [[nodiscard]] Endpoint endpoint() const { return server_.endpoint(); }

  [[nodiscard]] MessageSocket connect() const {
    auto socket = MessageSocket::connect(endpoint(), std::chrono::seconds(30));
    if (!socket) throw std::runtime_error(socket.error().text);
    return *std::move(socket);
  }
  // Connects and completes the handshake.
  [[nodiscard]] MessageSocket greet() const {
    MessageSocket socket = connect();
    EXPECT_TRUE(socket.send(Hello{}));
    const auto welcome = socket.receive();
    EXPECT_TRUE(welcome && std::holds_alternative<Welcome>(*welcome));
    return socket;
  }

 private:
  static ServerOptions on_a_free_port(ServerOptions options) {
    set_log_level(LogLevel::kOff);
    options.listen = {.host = "127.0.0.1", .port = 0};
    return options;
  }

  Server server_;
  std::thread thread_;
};

// Returns the next message if it is an M; otherwise fails the test and returns an empty M.
template <typename M>
M receive(MessageSocket& socket) {
  auto message = socket.receive();
  if (!message) {
    ADD_FAILURE() << message.error().text;
    return {};
  }
  if (const auto* error = std::get_if<ErrorReply>(&*message)) {
    if constexpr (!std::is_same_v<M, ErrorReply>) ADD_FAILURE() << error->error.text;
  }
  if (auto* wanted = std::get_if<M>(&*message)) return std::move(*wanted);
  ADD_FAILURE() << "another message: alternative " << message->index();
  return {};
}

// Returns whether the server closes the connection without another message.
inline bool is_closed_by_server(MessageSocket& socket) {
  const auto message = socket.receive();
  return !message && message.error().text.find("was lost") != std::string::npos;
}

}  // namespace multitetra::testing
