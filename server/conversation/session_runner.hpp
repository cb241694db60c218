// Runs a session: performs its actions, requests results from the service, and supplies the
// messages to send, one at a time. Independent of sockets, so TCP and WebSockets share it:
//
//   reading:  co_await until_readable(); read a message; receive(content)
//   writing:  while (auto message = co_await next_message()) write it
//   timer:    enforce_limits(now), periodically
//
// Memory use is bounded. Replies wait in a short queue; reading pauses while it is full or contains
// a list or a slice. Stream messages are made when the writing loop requests them. Waiting requests
// and replies reserve memory through admission control, or are refused. Clients that exceed their
// rate with large messages are paused.
//
// Not thread-safe: everything runs on the executor, with one thread at a time.
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

class SessionRunner : public std::enable_shared_from_this<SessionRunner> {
 public:
  // The session ends after `idle_time` without a message, a stream or a query; 0 disables this.
  SessionRunner(asio::any_io_executor executor, ServiceClientPtr service_client, Session session,
                ConnectionContextPtr client, std::chrono::milliseconds idle_time = {});

  // Handles the content of one frame or one WebSocket message; untrusted bytes.
  void receive(std::string_view content);
  // Sends the error, then ends the session.
  void end(const Error& error);
  // Drops all queued messages. Call when the client has disconnected.
  void on_disconnect();
  // Answers the request of `message`, taken from next_message() but too long to send, with an error
  // instead. The session continues.
  void reject_oversized_reply(const ServerMessage& message);
  void enforce_limits(std::chrono::steady_clock::time_point now);
  // Returns the start of the idle time; nullopt while a request is in progress.
  [[nodiscard]] std::optional<std::chrono::steady_clock::time_point> idle_since() const;
  // Sets the measured bandwidth to the client.
  void set_bandwidth(double bytes_per_second) { service_client_->set_bandwidth(bytes_per_second); }

  // Returns the next message to send, or nullopt when the session is over.
  [[nodiscard]] asio::awaitable<std::optional<ServerMessage>> next_message();
  // Waits until another message may be received.
  [[nodiscard]] asio::awaitable<void> until_readable();

  // Returns the longest message that may be received after Welcome.
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
  // Returns the dataset of a message if it exists but is hidden from the client.
  [[nodiscard]] std::string hidden_dataset(const ClientMessage& message) const;
  asio::awaitable<void> greet(Hello hello, std::size_t message_bytes,
                              asio::awaitable<Result<CataloguePtr>> finding);
  void perform(Actions actions);
  void perform(Send action);
  void perform(ValidatedStream action);
  void perform(ValidatedQuery action);
  void perform(StopStream action);
  void perform(Close action);

  void answer_made(std::uint64_t number, Result<DatasetQueryReply> made);
  [[nodiscard]] std::optional<ServerMessage> next_stream_message();
  // Logs and counts an error reply for which there is no record.
  void report(const ErrorReply& refusal);
  void reply(ServerMessage message, ByteReservations::Reservation reservation = {});
  void drop_stream();
  [[nodiscard]] bool has_room() const;
  [[nodiscard]] bool is_busy() const { return stream_ || !queries_.empty() || is_greeting_; }

  asio::any_io_executor executor_;
  ServiceClientPtr service_client_;
  Session session_;
  ConnectionContextPtr client_;
  // The dataset of the message being answered if the client may not see it. Only the log names it.
  std::string hidden_dataset_;
  bool is_over_ = false;
  // The dataset listing for the new client is in progress.
  bool is_greeting_ = false;
  // Reserved for the request that is about to start.
  ByteReservations::Reservation request_reservation_;
  std::deque<Reply> replies_;
  // Reserved for the reply that is being sent.
  ByteReservations::Reservation reply_reservation_;
  // Reading pauses until then because of the rate limit.
  std::chrono::steady_clock::time_point paused_until_ = {};
  std::optional<Stream> stream_;
  // Set while the final message of the previous stream is still queued.
  std::unique_ptr<RequestRecord> leaving_;
  std::map<std::uint64_t, RunningQuery> queries_;
  std::uint64_t last_query_ = 0;
  IdleWatch idleness_;
  AsyncEvent output_available_;
  AsyncEvent replies_taken_;
};

using SessionRunnerPtr = std::shared_ptr<SessionRunner>;

}  // namespace multitetra
