// One simulated user: connects, plays a script, checks all replies, and reconnects when the
// connection is lost. A coroutine; many sessions share a thread.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/load/agreement.hpp"
#include "client/load/load_statistics.hpp"
#include "client/load/script.hpp"
#include "client/load/stream_checks.hpp"
#include "common/net/async_event.hpp"
#include "common/net/message_channel.hpp"

namespace multitetra {

using LoadClock = std::chrono::steady_clock;

struct UserOptions {
  Endpoint server;
  TlsContextPtr tls = nullptr;
  std::string token = {};
  std::string dataset = {};  // Empty: all datasets of the server.
  // Stays connected and requests nothing.
  bool is_idle = false;
  ScriptKind script = ScriptKind::kMixed;
  ScriptOptions script_options = {};
  // One in this many streams is checked thoroughly; of the others, one in this many tiles is
  // decoded.
  std::uint32_t streams_per_thorough = 16;
  std::uint32_t tiles_per_decoded = 16;
  std::chrono::milliseconds timeout{60'000};  // The longest wait for a message.
  LoadClock::time_point start = {};           // No session connects before this time.
  // No session makes requests after this time.
  LoadClock::time_point stop = {};
  // No session waits for replies after this time.
  LoadClock::time_point give_up = {};
};

class LoadSession {
 public:
  // All references must outlive run(), and the session must outlive the executor's work.
  LoadSession(asio::io_context& io, const UserOptions& options, std::uint64_t seed,
              std::chrono::milliseconds delay, std::string from, LoadStatistics& statistics,
              Agreement& agreement);
  ~LoadSession();
  LoadSession(const LoadSession&) = delete;
  LoadSession& operator=(const LoadSession&) = delete;

  [[nodiscard]] asio::awaitable<void> run();

 private:
  struct RunningStream;
  using ChannelPtr = std::shared_ptr<MessageChannel>;

  asio::awaitable<bool> connect();
  asio::awaitable<Result<std::vector<DatasetInfo>>> enter(ChannelPtr channel);
  asio::awaitable<Result<ServerMessage>> request(ChannelPtr channel, std::string content);
  asio::awaitable<void> listen(ChannelPtr channel);
  asio::awaitable<void> play(ScriptedRequest scripted);
  asio::awaitable<void> act_or_wait();
  void count_ended_stream();
  asio::awaitable<void> send_open_stream();
  asio::awaitable<void> reconnect();
  asio::awaitable<void> wait_until(LoadClock::time_point time);
  void take(const ServerMessage& message);
  void take_progress(const StreamProgress& progress);
  void take_refusal(const Error& error);
  void note_tile(const Tile& tile);
  void fail_check(const std::string& text);
  void handle_lost_connection(const Error& error);
  void leave();
  void notify();

  const UserOptions& options_;
  LoadStatistics& statistics_;
  Agreement& agreement_;
  asio::io_context& io_;
  AsyncEvent news_;
  bool has_news_ = false;
  std::mt19937_64 random_;
  std::uint64_t seed_;
  std::chrono::milliseconds delay_;
  std::string from_;  // The local address to connect from; empty: chosen by the system.

  ChannelPtr channel_;  // Null when not connected.
  std::vector<DatasetInfo> datasets_;
  std::optional<Script> script_;
  std::uint64_t last_request_id_ = 0;
  std::uint64_t streams_ = 0;
  int failures_in_a_row_ = 0;
  // The delay required by the last rejection.
  std::chrono::milliseconds least_wait_{0};
  std::unique_ptr<RunningStream> stream_;
};

}  // namespace multitetra
