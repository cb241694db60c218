// Messages with one server, blocking, with a limit on every wait.
//
// Failures of the network or of the server's bytes are an Error: kUnavailable when the server
// cannot be reached, is silent for too long or closes the connection; the codes of frame.hpp and
// messages.hpp when its bytes are no messages; kInvalidArgument when the address requires TLS or a
// WebSocket and the server has none; kLimitExceeded when the deadline is over. After an error the
// connection is closed, and every later call is kUnavailable.
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

  // `timeout` holds for connecting, for sending one message, and for the silence of the server
  // while a message is awaited; the deadline for all of it together, however much comes. A wait
  // that `interrupt` ends gives kCancelled.
  [[nodiscard]] static Result<MessageSocket> connect(const Endpoint& server,
                                                     std::chrono::milliseconds timeout,
                                                     const ChannelOptions& options = {},
                                                     Deadline deadline = {},
                                                     Interrupt interrupt = {});

  MessageSocket(MessageSocket&&) noexcept;
  MessageSocket& operator=(MessageSocket&&) noexcept;
  ~MessageSocket();

  [[nodiscard]] Result<void> send(const ClientMessage& message);
  // Bytes as they are, for tests of what a server makes of them.
  [[nodiscard]] Result<void> send_bytes(std::string_view bytes);
  [[nodiscard]] Result<ServerMessage> receive();
  // The same with a limit of its own: nullopt when no whole message came within `patience`,
  // which is no error. The part of one that came is kept.
  [[nodiscard]] Result<std::optional<ServerMessage>> receive_within(
      std::chrono::milliseconds max_wait);

 private:
  struct State;
  explicit MessageSocket(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace multitetra
