// A session at work: performs its actions, has steps made by the workers, and hands out the
// messages to send, one at a time. It knows no socket, so that TCP and WebSocket share it: how a
// transport uses it says session.hpp.
//
// Memory is bounded whatever the client does: replies wait in a short queue, of which one may be a
// list of datasets, and reading pauses while it is full; stream messages are made when the writing
// loop asks for them, and a step only when the one before has gone. At most one step is with the
// workers, also when streams supersede each other. Workers never wait for a client.
//
// Only the making of steps happens on other threads than the executor's.
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>

#include "common/net/net.hpp"
#include "server/operations/admission_control.hpp"
#include "server/session/session.hpp"
#include "server/stream/stream_messages.hpp"
#include "server/stream/workers.hpp"
#include "server/transport/idle_watch.hpp"
#include "server/transport/message_session.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxWaitingReplies = 64;

// Zero is no limit.
struct SessionLimits {
  std::chrono::milliseconds request_time{0};  // Of workers, for one stream or estimate.
  std::chrono::milliseconds idle_time{0};     // Without a message from the client or a stream.
  std::uint64_t max_triangles = 0;            // Of a final step.
};

class StreamSession : public MessageSession, public std::enable_shared_from_this<StreamSession> {
 public:
  // The workers must live until their work is done, the client's admission as long as this.
  StreamSession(asio::any_io_executor executor, Workers& workers, Session session,
                ClientContextPtr client, SessionLimits limits = {});

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
  struct RunningStream;
  struct RunningEstimate;

  void perform(Actions actions);
  void perform(Send action);
  void perform(StartStream action);
  void perform(MakeEstimate action);
  void perform(StopStream action);
  void perform(Close action);

  // Unless one is being made: step_made() calls it again then.
  void make_next_step();
  // A worker begins with it: from now on its time counts.
  void watch_worker(const std::shared_ptr<RunningStream>& stream);
  void watch_worker(const std::shared_ptr<RunningEstimate>& estimate);
  void estimate_made(const std::shared_ptr<RunningEstimate>& estimate, Result<EstimateReply> made);
  void watch_idleness();
  void step_made(const std::shared_ptr<RunningStream>& stream, Result<MadeStep> step,
                 double seconds);
  [[nodiscard]] std::optional<ServerMessage> take_stream_message();
  [[nodiscard]] ServerMessage told(ServerMessage message);
  // The running stream cannot go on; the conversation can. Requires a running stream.
  void fail_stream(Error error);
  void drop_stream();
  [[nodiscard]] bool has_room() const;

  asio::any_io_executor executor_;
  Workers& workers_;
  FairQueue::Client queue_client_;  // Of the workers.
  Session session_;
  ClientContextPtr client_;
  SessionLimits limits_;
  bool is_over_ = false;
  bool has_heard_ = false;  // Of the client.
  std::deque<ServerMessage> replies_;
  std::shared_ptr<RunningStream> stream_;
  // Of the stream that has ended last, until its last message has left.
  std::unique_ptr<RequestRecord> leaving_;
  std::set<std::shared_ptr<RunningEstimate>> estimates_;
  bool is_making_ = false;  // A step is with the workers: of stream_, or of one that was stopped.
  asio::steady_timer worker_timer_;  // Runs while a step of stream_ is with a worker.
  IdleWatch idleness_;
  // Timers that never expire; cancelling one wakes who waits on it.
  asio::steady_timer something_to_send_;
  asio::steady_timer replies_taken_;
};

}  // namespace multitetra
