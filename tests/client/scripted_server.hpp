// A server that sends scripted bytes to one client, once, whatever the client sends.
#pragma once

#include <array>
#include <future>
#include <string>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"
#include "common/net/net.hpp"
#include "common/wire/messages.hpp"

namespace multitetra::testing {

inline std::string framed(std::string_view content) {
  return frame_header(static_cast<std::uint32_t>(content.size())).append(content);
}

template <typename Messages>
std::string framed_messages(const Messages& messages) {
  std::string bytes;
  for (const ServerMessage& message : messages) bytes += framed(serialize(message));
  return bytes;
}

enum class ThenTheServer { kWaits, kHangsUp };

class ScriptedServer {
 public:
  explicit ScriptedServer(std::string bytes, ThenTheServer then = ThenTheServer::kWaits)
      : client_left_(std::async(std::launch::async, [this, bytes = std::move(bytes), then] {
          tcp::socket socket = acceptor_.accept();
          boost::system::error_code error;
          asio::write(socket, asio::buffer(bytes), error);
          if (then == ThenTheServer::kHangsUp) socket.shutdown(tcp::socket::shutdown_send, error);
          std::array<char, 4096> heard{};
          for (error = {}; !error;) socket.read_some(asio::buffer(heard), error);
        })) {}

  // Connects and disconnects, so that the thread ends even if no client has connected.
  ~ScriptedServer() {
    boost::system::error_code ignored;
    tcp::socket(io_).connect(acceptor_.local_endpoint(), ignored);
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  [[nodiscard]] Endpoint endpoint() const { return {.host = "127.0.0.1", .port = port_}; }

  // Returns whether the client closes the connection within five seconds.
  [[nodiscard]] bool client_leaves() const {
    return client_left_.wait_for(std::chrono::seconds(5)) == std::future_status::ready;
  }

 private:
  asio::io_context io_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::uint16_t port_ = acceptor_.local_endpoint().port();
  std::future<void> client_left_;  // The destructor waits for the thread.
};

}  // namespace multitetra::testing
