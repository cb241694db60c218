// A conversation as a transport sees it: bytes of messages in, messages out.
//
// A transport runs two loops on the same executor:
//
//   reading:  co_await room(); read a message; receive(content)
//   writing:  while (auto message = co_await next_message()) write it
//
// So one transport serves a session of this process (StreamSession) or one that somebody else
// holds, and one session is held over TCP frames or WebSocket messages alike.
//
// Not thread-safe: everything runs on the executor, of which one thread runs at a time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/net/net.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

class MessageSession {
 public:
  virtual ~MessageSession() = default;

  // The content of one frame or one WebSocket message, of untrusted bytes.
  virtual void receive(std::string_view content) = 0;
  // Says why, then ends the conversation.
  virtual void end(const Error& error) = 0;
  // The client is gone: drops everything that was to be sent.
  virtual void leave() = 0;
  // `message`, of next_message(), is too long to be sent: its request is answered with an error
  // instead, and the conversation goes on.
  virtual void give_up(const ServerMessage& message) = 0;

  // The next message to send; nullopt when the conversation is over.
  [[nodiscard]] virtual asio::awaitable<std::optional<ServerMessage>> next_message() = 0;
  // Returns when another message may be received.
  [[nodiscard]] virtual asio::awaitable<void> room() = 0;

  [[nodiscard]] virtual bool is_welcomed() const = 0;
  [[nodiscard]] virtual bool is_over() const = 0;
  // Names the client in the log.
  [[nodiscard]] virtual const std::string& peer() const = 0;
};

using MessageSessionPtr = std::shared_ptr<MessageSession>;

}  // namespace multitetra
