#include "client/message_socket.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "common/net.hpp"

namespace multitetra {

using boost::system::error_code;
using Clock = std::chrono::steady_clock;

struct MessageSocket::State {
  State(Endpoint server_in, std::chrono::milliseconds timeout_in, std::uint32_t max_message_bytes)
      : server(std::move(server_in)), timeout(timeout_in), frames(max_message_bytes) {}

  Endpoint server;
  std::chrono::milliseconds timeout;
  FrameReader frames;
  asio::io_context io{1};
  tcp::socket socket{io};
  tcp::resolver resolver{io};
  Clock::time_point last_sign = Clock::now();  // That a message was sent or bytes came.

  // Runs what was started until it completes. nullopt when it took too long; it is then given up
  // and the socket closed. Otherwise the operation's own error.
  std::optional<error_code> wait(const std::optional<error_code>& outcome) {
    io.restart();
    io.run_for(timeout);
    if (outcome) return outcome;
    resolver.cancel();
    close();
    io.restart();
    io.run();
    return std::nullopt;
  }

  // The same, but what takes too long is only put off: the socket stays open. Bytes that come while
  // the operation is called back are not lost, because the outcome then says so.
  std::optional<error_code> wait_within(std::chrono::milliseconds patience,
                                        const std::optional<error_code>& outcome) {
    io.restart();
    io.run_for(patience);
    if (outcome) return outcome;
    error_code ignored;
    socket.cancel(ignored);
    io.restart();
    io.run();
    if (outcome == asio::error::operation_aborted) return std::nullopt;
    return outcome;
  }

  [[nodiscard]] std::chrono::milliseconds silence() const {
    return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - last_sign);
  }

  void close() {
    error_code ignored;
    socket.close(ignored);
  }

  // How every operation that fails ends.
  [[nodiscard]] tl::unexpected<Error> closed(tl::unexpected<Error> error) {
    close();
    return error;
  }
  [[nodiscard]] tl::unexpected<Error> silent(const std::string& what) const {
    return fail(ErrorCode::kUnavailable, to_string(server) + " " + what + " within " +
                                             std::to_string(timeout.count() / 1000) +
                                             " s; try a longer timeout.");
  }
  [[nodiscard]] tl::unexpected<Error> lost(const error_code& error) const {
    return fail(ErrorCode::kUnavailable,
                "The connection to " + to_string(server) + " was lost: " + error.message() + ".");
  }
};

namespace {

tl::unexpected<Error> unreachable(const Endpoint& server, const error_code& error) {
  std::string text = "Cannot connect to " + to_string(server) + ": " + error.message() + ".";
  if (error == asio::error::connection_refused) {
    text += " Is the server running? Start it with: multitetra-server serve DATASET.mtd --tcp " +
            to_string(server);
  } else if (error == asio::error::host_not_found) {
    text += " Is the host's name written correctly?";
  }
  return fail(ErrorCode::kUnavailable, std::move(text));
}

}  // namespace

MessageSocket::MessageSocket(std::unique_ptr<State> state) : state_(std::move(state)) {}
MessageSocket::MessageSocket(MessageSocket&&) noexcept = default;
MessageSocket& MessageSocket::operator=(MessageSocket&&) noexcept = default;
MessageSocket::~MessageSocket() = default;

Result<MessageSocket> MessageSocket::connect(const Endpoint& server,
                                             std::chrono::milliseconds timeout,
                                             std::uint32_t max_message_bytes) {
  auto state = std::make_unique<State>(server, timeout, max_message_bytes);
  std::optional<error_code> outcome;
  state->resolver.async_resolve(
      server.host, std::to_string(server.port),
      [&](const error_code& error, const tcp::resolver::results_type& found) {
        if (error) {
          outcome = error;
          return;
        }
        asio::async_connect(
            state->socket, found,
            [&](const error_code& connected, const tcp::endpoint&) { outcome = connected; });
      });
  const auto error = state->wait(outcome);
  if (!error) return state->silent("did not accept the connection");
  if (*error) return unreachable(server, *error);
  error_code ignored;
  state->socket.set_option(tcp::no_delay(true), ignored);
  return MessageSocket(std::move(state));
}

Result<void> MessageSocket::send(const ClientMessage& message) {
  const std::string content = serialize(message);
  return send_bytes(frame_header(static_cast<std::uint32_t>(content.size())) + content);
}

Result<void> MessageSocket::send_bytes(std::string_view bytes) {
  if (!state_->socket.is_open()) return state_->lost(asio::error::not_connected);
  std::optional<error_code> outcome;
  asio::async_write(state_->socket, asio::buffer(bytes),
                    [&](const error_code& error, std::size_t) { outcome = error; });
  const auto error = state_->wait(outcome);
  if (!error) return state_->silent("did not take our message");
  if (*error) return state_->closed(state_->lost(*error));
  state_->last_sign = Clock::now();
  return {};
}

Result<ServerMessage> MessageSocket::receive() {
  state_->last_sign = Clock::now();
  for (;;) {
    auto message = receive_within(state_->timeout);
    if (!message) return tl::unexpected(message.error());
    if (*message) return **std::move(message);
  }
}

Result<std::optional<ServerMessage>> MessageSocket::receive_within(
    std::chrono::milliseconds patience) {
  if (!state_->socket.is_open()) return state_->lost(asio::error::not_connected);
  const Clock::time_point until = Clock::now() + patience;
  std::array<char, 64 * 1024> buffer{};
  for (;;) {
    auto content = state_->frames.next();
    if (!content) return state_->closed(tl::unexpected(content.error()));
    if (*content) {
      auto message = parse_server_message(**content);
      if (!message) return state_->closed(tl::unexpected(message.error().error));
      return *std::move(message);
    }
    if (state_->silence() >= state_->timeout) {
      return state_->closed(state_->silent("sent nothing"));
    }
    const auto left =
        std::min(std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()) +
                     std::chrono::milliseconds(1),
                 state_->timeout - state_->silence());
    std::optional<error_code> outcome;
    std::size_t received = 0;
    state_->socket.async_read_some(asio::buffer(buffer),
                                   [&](const error_code& error, std::size_t size) {
                                     outcome = error;
                                     received = size;
                                   });
    const auto error = state_->wait_within(left, outcome);
    if (error && *error) return state_->closed(state_->lost(*error));
    if (error) {
      state_->last_sign = Clock::now();
      state_->frames.feed({buffer.data(), received});
    } else if (Clock::now() >= until && state_->silence() < state_->timeout) {
      return std::nullopt;
    }
  }
}

}  // namespace multitetra
