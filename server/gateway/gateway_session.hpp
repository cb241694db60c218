// A conversation whose streams other servers make. It holds the session itself, with the datasets
// that those servers offer, so that every answer is the one that a server gives; only streams and
// estimates are passed on. When a server is lost in the middle of a stream, another one that has
// the same dataset is asked the same, and the client notices nothing but a pause.
//
// Memory is bounded: a few messages wait for the client, and what comes behind them waits in the
// socket of the server that sends it.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "server/gateway/forwarded_stream.hpp"
#include "server/gateway/upstream_estimates.hpp"
#include "server/gateway/upstream_pool.hpp"
#include "server/operations/admission_control.hpp"
#include "server/session/session.hpp"
#include "server/transport/idle_watch.hpp"
#include "server/transport/message_session.hpp"

namespace multitetra {

class GatewaySession : public MessageSession, public std::enable_shared_from_this<GatewaySession> {
 public:
  GatewaySession(asio::any_io_executor executor, std::shared_ptr<UpstreamPool> gateway,
                 SessionOptions options, ClientContextPtr client,
                 std::chrono::milliseconds idle_time = {});

  void receive(std::string_view content) override;
  void end(const Error& error) override;
  void leave() override;
  void give_up(const ServerMessage& message) override;

  [[nodiscard]] asio::awaitable<std::optional<ServerMessage>> next_message() override;
  [[nodiscard]] asio::awaitable<void> room() override;

  [[nodiscard]] bool is_welcomed() const override { return session_.is_welcomed(); }
  [[nodiscard]] bool is_over() const override { return is_over_; }
  [[nodiscard]] const std::string& peer() const override { return client_->facts().peer; }

 private:
  using RecordPtr = std::shared_ptr<RequestRecord>;
  struct Running {
    ForwardedStream stream;
    std::shared_ptr<const UpstreamDataset> dataset;
    RecordPtr record;
    bool is_asked = false;  // A server was asked for it.
    bool is_stopped = false;
    std::chrono::steady_clock::time_point last_progress = std::chrono::steady_clock::now();
  };
  using RunningPtr = std::shared_ptr<Running>;
  struct Outgoing {
    ServerMessage message;
    RecordPtr record;  // Of the request that it answers a part of; may be null.
  };

  void perform(Actions actions);
  void perform(Send action);
  void perform(StartStream action);
  void perform(MakeEstimate action);
  void perform(StopStream action);
  void perform(Close action);

  // Fetches what servers offer, then lets the session answer.
  asio::awaitable<void> greet(Hello hello);
  // Brings all streams, one after the other, until the conversation is over.
  asio::awaitable<void> bring_streams();
  asio::awaitable<void> bring(RunningPtr running);
  // Makes sure that reached_ is a holder of its dataset; false when the stream cannot go on.
  asio::awaitable<bool> reach_holder(RunningPtr running);
  // Until the stream is over (true) or the server lost (false).
  asio::awaitable<bool> forward(RunningPtr running);
  asio::awaitable<void> bring_estimate(MakeEstimate action);
  void take(const RunningPtr& running, ServerMessage message);
  void finish(const RunningPtr& running, ServerMessage last);
  void watch_idleness();
  void close_links();
  void say(ServerMessage message, RecordPtr record = nullptr);
  [[nodiscard]] ServerMessage told(Outgoing outgoing);
  void wake();

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  UpstreamEstimates estimates_;
  SessionOptions options_;
  Session session_;
  ClientContextPtr client_;
  std::string token_;
  bool is_over_ = false;
  bool is_greeting_ = false;
  bool is_bringing_ = false;
  bool has_heard_ = false;  // Of the client.
  std::deque<Outgoing> outgoing_;
  RecordPtr leaving_;  // Of the request whose last message is on its way.
  RunningPtr running_;
  std::optional<UpstreamPool::Reached> reached_;  // Of the last stream, for the next.
  IdleWatch idleness_;
  // Never expires; cancelling it wakes all who wait for something to change.
  asio::steady_timer change_;
};

}  // namespace multitetra
