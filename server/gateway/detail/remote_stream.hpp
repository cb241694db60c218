// One stream that is forwarded from a server: the messages queued for the client, and the progress
// of forwarding. Independent of connections.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "server/gateway/detail/forwarded_stream.hpp"
#include "server/gateway/detail/upstream_pool.hpp"
#include "server/service/surface_service.hpp"
#include "server/session/answers.hpp"

namespace multitetra {

class RemoteStream : public ProgressiveStream {
 public:
  using Clock = std::chrono::steady_clock;
  // Called synchronously from within the causing call.
  struct Events {
    // The client may have another message to take.
    std::function<void()> changed;
    // The queue has space.
    std::function<void()> taken;
    std::function<void(RemoteStream&)> stopped;
  };

  RemoteStream(ValidatedStream action, Events events)
      : forwarded(std::move(action.open)),
        dataset(std::dynamic_pointer_cast<const UpstreamDataset>(action.source)),
        shells(action.shells),
        events_(std::move(events)) {}

  std::optional<ServerMessage> take() override {
    if (waiting_.empty()) return std::nullopt;
    ServerMessage message = std::move(waiting_.front());
    waiting_.pop_front();
    if (std::holds_alternative<StepEnd>(message)) ++steps_sent_;
    events_.taken();
    return message;
  }
  void end(StreamOutcome outcome) override {
    finish(StreamEnd{.request_id = id(), .outcome = outcome, .steps = steps_sent_});
  }
  void fail(Error error) override {
    finish(ErrorReply{.request_id = id(), .error = std::move(error)});
  }
  void drop() override {
    is_finished_ = true;
    waiting_.clear();
    stop();
  }

  // Fails before the client has received anything of the stream.
  void refuse(Error error) {
    waiting_.push_back(ErrorReply{.request_id = id(), .error = std::move(error)});
    is_finished_ = is_stopped = true;
  }
  // Queues a message of the server. The last one ends the stream.
  void put(ServerMessage message) {
    const bool is_end = is_last(message);
    waiting_.push_back(std::move(message));
    if (is_end) is_stopped = true;
    events_.changed();
  }
  [[nodiscard]] bool has_room() const { return waiting_.size() < kMaxWaiting; }
  [[nodiscard]] std::uint64_t id() const { return forwarded.open().request_id; }

  ForwardedStream forwarded;
  std::shared_ptr<const UpstreamDataset> dataset;
  const bool shells;  // Sample shells allowed; constant per client.
  // Whether the stream was requested from a server and has not ended there.
  bool is_requested = false;
  bool is_stopped = false;
  // The time at which the server was lost; reset once a message is forwarded.
  std::optional<Clock::time_point> lost_at = {};

 private:
  // Replaces the queued messages with the final one.
  void finish(ServerMessage last) {
    if (std::exchange(is_finished_, true)) return;
    waiting_.clear();
    waiting_.push_back(std::move(last));
    stop();
    events_.changed();
  }
  // Cancels the stream at the server, which frees the link for the next stream.
  void stop() {
    is_stopped = true;
    events_.stopped(*this);
  }

  static constexpr std::size_t kMaxWaiting = 4;  // Reading from the server pauses beyond that.

  // The final message was set here.
  bool is_finished_ = false;
  std::deque<ServerMessage> waiting_;
  std::uint32_t steps_sent_ = 0;
  Events events_;
};

}  // namespace multitetra
