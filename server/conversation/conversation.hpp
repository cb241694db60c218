// A session at work: performs its actions, has the service make what is answered, and hands out the
// messages to send, one at a time. It knows no socket, so that TCP and WebSockets share it:
//
//   reading:  co_await until_readable(); read a message; receive(content)
//   writing:  while (auto message = co_await next_message()) write it
//   and, as time goes by, keep_time(now)
//
// Memory is bounded whatever the client does: replies wait in a short queue, of which one may be a
// list of datasets and some are slices, and reading pauses while it is full or has one of those;
// stream messages are made when the writing loop asks for them. Waiting requests and replies have
// reservations in the admission's queue, or are refused; clients that send large messages too often
// are paused.
//
// Not thread-safe: everything runs on the executor, of which one thread runs at a time.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "common/net/async_event.hpp"
#include "server/conversation/detail/idle_watch.hpp"
#include "server/operations/admission_control.hpp"
#include "server/service/surface_service.hpp"
#include "server/session/session.hpp"

namespace multitetra {

class Conversation : public std::enable_shared_from_this<Conversation> {
 public:
  // `idle_time` without a message from the client, a stream or an estimate ends it; 0: nothing
  // does.
  Conversation(asio::any_io_executor executor, CallerPtr caller, Session session,
               ConnectionContextPtr client, std::chrono::milliseconds idle_time = {});

  // The content of one frame or one WebSocket message, of untrusted bytes.
  void receive(std::string_view content);
  // Says why, then ends the session.
  void end(const Error& error);
  // The client is gone: drops everything that was to be sent.
  void leave();
  // `message`, of next_message(), is too long to be sent: its request is answered with an error
  // instead, and the session continues.
  void reject_oversized_reply(const ServerMessage& message);
  void keep_time(std::chrono::steady_clock::time_point now);
  // Idle since then; nullopt while a request is in progress.
  [[nodiscard]] std::optional<std::chrono::steady_clock::time_point> idle_since() const;
  // The measured bandwidth to the client.
  void set_bandwidth(double bytes_per_second) { caller_->set_bandwidth(bytes_per_second); }

  // The next message to send; nullopt when the session is over.
  [[nodiscard]] asio::awaitable<std::optional<ServerMessage>> next_message();
  // Returns when another message may be received.
  [[nodiscard]] asio::awaitable<void> until_readable();

  // The longest message that may be received once the client is welcomed.
  [[nodiscard]] std::uint32_t max_message_bytes() const { return session_.max_message_bytes(); }
  [[nodiscard]] bool is_welcomed() const { return session_.is_welcomed(); }
  [[nodiscard]] bool is_over() const { return is_over_; }

 private:
  struct Stream {
    std::uint64_t request_id = 0;
    ProgressiveStreamPtr messages;
    std::unique_ptr<RequestRecord> record;
    ByteReservations::Reservation reservation = {};
  };
  struct RunningQuery {
    std::uint64_t request_id = 0;
    std::unique_ptr<RequestRecord> record;
    std::stop_source stop = {};
    ByteReservations::Reservation reservation = {};
  };
  struct Reply {
    ServerMessage message;
    ByteReservations::Reservation reservation = {};
  };

  void take(const tl::expected<ClientMessage, ParseError>& message, std::size_t message_bytes);
  void note_hidden_dataset(const ClientMessage& message);
  asio::awaitable<void> greet(Hello hello, std::size_t message_bytes,
                              asio::awaitable<Result<CataloguePtr>> finding);
  void perform(Actions actions);
  void perform(Send action);
  void perform(StartStream action);
  void perform(RunQuery action);
  void perform(StopStream action);
  void perform(Close action);

  void answer_made(std::uint64_t number, Result<DatasetQueryReply> made);
  [[nodiscard]] std::optional<ServerMessage> next_stream_message();
  [[nodiscard]] ServerMessage note_reply(ServerMessage message);
  void reply(ServerMessage message, ByteReservations::Reservation reservation = {});
  void drop_stream();
  [[nodiscard]] bool has_room() const;
  [[nodiscard]] bool is_busy() const { return stream_ || !queries_.empty() || is_greeting_; }

  asio::any_io_executor executor_;
  CallerPtr caller_;
  Session session_;
  ConnectionContextPtr client_;
  // By request, datasets that the client asked for and may not see: the log names them so.
  std::map<std::uint64_t, std::string> hidden_datasets_;
  bool is_over_ = false;
  // The dataset listing for the new client is in progress.
  bool is_greeting_ = false;
  // The memory reserved for the request that is about to start.
  ByteReservations::Reservation request_reservation_;
  std::deque<Reply> replies_;
  // The memory of the reply that is being sent.
  ByteReservations::Reservation reply_reservation_;
  // Reading is paused until then (rate limit).
  std::chrono::steady_clock::time_point quiet_until_ = {};
  std::optional<Stream> stream_;
  // Set while the final message of the previous stream is still queued.
  std::unique_ptr<RequestRecord> leaving_;
  std::map<std::uint64_t, RunningQuery> queries_;  // By a number of their own.
  std::uint64_t last_query_ = 0;
  IdleWatch idleness_;
  AsyncEvent something_to_send_;
  AsyncEvent replies_taken_;
};

using ConversationPtr = std::shared_ptr<Conversation>;

}  // namespace multitetra
