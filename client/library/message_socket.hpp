// A blocking message connection to one server, with a limit on every wait.
//
// Failures of the network and malformed messages are an Error: kUnavailable if the server cannot be
// reached, is silent for too long or closes the connection; the codes of frame.hpp and messages.hpp
// if its bytes are not valid messages; kInvalidArgument if the address requires TLS or a WebSocket
// and the server offers none; kLimitExceeded after the deadline. An error closes the connection,
// and every later call returns kUnavailable.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "client/library/interrupt.hpp"
#include "common/net/channel_options.hpp"
#include "common/net/endpoint.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

class MessageSocket {
 public:
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  // `timeout` limits connecting, sending one message, and the time without progress of a request;
  // `deadline` limits the whole connection. `interrupt` ends a wait with kCancelled.
  [[nodiscard]] static Result<MessageSocket> connect(const Endpoint& server,
                                                     std::chrono::milliseconds timeout,
                                                     const ChannelOptions& options = {},
                                                     Deadline deadline = {},
                                                     Interrupt interrupt = {});

  MessageSocket(MessageSocket&&) noexcept;
  MessageSocket& operator=(MessageSocket&&) noexcept;
  ~MessageSocket();

  [[nodiscard]] Result<void> send(const ClientMessage& message);
  // Sends raw bytes, to test how servers handle them.
  [[nodiscard]] Result<void> send_bytes(std::string_view bytes);
  // Receives the answer to the last message sent. Neither a Pong nor a few bytes of a message count
  // as progress, and at `until` it fails with kLimitExceeded.
  [[nodiscard]] Result<ServerMessage> receive(Deadline until = {});
  // Receives a message of a stream whose server is pinged: returns nullopt when no whole one
  // arrived within `max_wait`, and allows ten times the timeout without progress while Pongs
  // arrive. A partly received message is kept for the next call.
  [[nodiscard]] Result<std::optional<ServerMessage>> receive_within(
      std::chrono::milliseconds max_wait);

 private:
  [[nodiscard]] Result<std::optional<ServerMessage>> received_within(
      std::chrono::milliseconds max_wait, int allowed_timeouts);
  struct State;
  explicit MessageSocket(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace multitetra
