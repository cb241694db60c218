// A session at work: performs its actions, has steps made by the workers, and hands out the
// messages to send, one at a time. It knows no socket, so that TCP and WebSocket share it.
//
// A transport runs two loops on the same executor:
//
//   reading:  co_await room(); read a message; receive(content)
//   writing:  while (auto message = co_await next_message()) write it
//
// Memory is bounded whatever the client does: replies wait in a short queue, of which one may be a
// list of datasets, and reading pauses while it is full; stream messages are made when the writing
// loop asks for them, and a step only when the one before has gone. At most one step is with the
// workers, also when streams supersede each other. Workers never wait for a client.
//
// Not thread-safe: everything runs on the executor, of which one thread runs at a time. Only the
// making of steps happens elsewhere.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "common/net.hpp"
#include "server/service/session.hpp"
#include "server/service/stream_messages.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxWaitingReplies = 64;

class Conversation : public std::enable_shared_from_this<Conversation> {
 public:
  // `peer` names the client in the log. The workers must live until their work is done.
  Conversation(asio::any_io_executor executor, Workers& workers, Session session, std::string peer);

  // The content of one frame, of untrusted bytes.
  void receive(std::string_view content);
  // Says why, then ends the conversation.
  void end(const Error& error);
  // The client is gone: drops everything that was to be sent.
  void leave();
  // `message`, of next_message(), is too long to be sent: its request is answered with an error
  // instead, and the conversation goes on.
  void give_up(const ServerMessage& message);

  // The next message to send; nullopt when the conversation is over.
  [[nodiscard]] asio::awaitable<std::optional<ServerMessage>> next_message();
  // Returns when another message may be received.
  [[nodiscard]] asio::awaitable<void> room();

  [[nodiscard]] bool is_welcomed() const { return session_.is_welcomed(); }
  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }

 private:
  struct RunningStream;

  void perform(Actions actions);
  void perform(Send action);
  void perform(StartStream action);
  void perform(MakeEstimate action);
  void perform(StopStream action);
  void perform(Close action);

  // Unless one is being made: step_made() calls it again then.
  void make_next_step();
  void step_made(const std::shared_ptr<RunningStream>& stream, Result<MadeStep> step,
                 double seconds);
  [[nodiscard]] std::optional<ServerMessage> take_stream_message();
  // The running stream cannot go on; the conversation can. Requires a running stream.
  void fail_stream(Error error);
  void drop_stream();
  [[nodiscard]] bool has_room() const;

  asio::any_io_executor executor_;
  Workers& workers_;
  FairQueue::Client client_;  // Of the workers.
  Session session_;
  std::string peer_;
  bool is_over_ = false;
  std::deque<ServerMessage> replies_;
  std::shared_ptr<RunningStream> stream_;
  std::stop_source estimates_stop_;
  bool is_making_ = false;  // A step is with the workers: of stream_, or of one that was stopped.
  // Timers that never expire; cancelling one wakes who waits on it.
  asio::steady_timer something_to_send_;
  asio::steady_timer replies_taken_;
};

}  // namespace multitetra
