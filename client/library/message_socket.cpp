#include "client/library/message_socket.hpp"

#include <algorithm>

#include "common/base/number_text.hpp"
#include "common/net/message_channel.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;

// The longest wait for the closing handshake of a connection.
constexpr auto kGoodbye = std::chrono::milliseconds(250);

// A server that makes no progress is dropped after this many timeouts; the second if it is pinged
// and answers. Bytes of an incomplete message count as progress at the rate below.
constexpr int kTimeoutsWithoutProgress = 1;
constexpr int kTimeoutsWhilePinged = 10;
constexpr double kSlowestBytesPerSecond = 1024;

struct MessageSocket::State {
  State(const Endpoint& server, std::chrono::milliseconds timeout_in, const ChannelOptions& options,
        Deadline deadline_in, Interrupt interrupt_in)
      : timeout(timeout_in),
        deadline(deadline_in.value_or(Clock::time_point::max())),
        interrupt(std::move(interrupt_in)),
        channel(io.get_executor(), server, options) {}

  ~State() {
    if (channel.is_open()) {
      std::optional<Result<void>> gone;
      start(left(), gone);
      run_until(Clock::now() + kGoodbye, [&] { return gone.has_value(); });
    }
    finish();
  }

  std::chrono::milliseconds timeout;
  Clock::time_point deadline;
  Interrupt interrupt;
  Clock::time_point interrupt_checked = Clock::now();
  bool is_interrupted = false;
  asio::io_context io{1};
  MessageChannel channel;
  // A started receive continues during other operations and across calls.
  bool is_receiving = false;
  std::optional<Result<std::string>> received;
  // When the current wait for a message began.
  Clock::time_point waiting_since = Clock::now();
  // When a request was last sent or a message other than Pong last arrived.
  Clock::time_point progress = Clock::now();
  std::uint64_t bytes_at_progress = 0;
  int allowed_timeouts = kTimeoutsWithoutProgress;
  // The limits of the connection and of the current wait.
  Clock::time_point wait_ends = Clock::time_point::max();

  [[nodiscard]] Clock::time_point ends_at() const { return std::min(deadline, wait_ends); }
  void note_progress() {
    progress = Clock::now();
    bytes_at_progress = channel.bytes_received();
  }
  [[nodiscard]] Clock::time_point stalled_at() const {
    const auto bytes = static_cast<double>(channel.bytes_received() - bytes_at_progress);
    const std::chrono::duration<double> under_way(bytes / kSlowestBytesPerSecond);
    return progress + allowed_timeouts * timeout +
           std::chrono::duration_cast<Clock::duration>(under_way);
  }

  asio::awaitable<Result<void>> left() {
    co_await channel.close_gracefully();
    co_return Result<void>();
  }

  // Starts the operation. `outcome` gets its result and must live until then or until finish().
  template <typename T>
  void start(asio::awaitable<Result<T>> operation, std::optional<Result<T>>& outcome) {
    asio::co_spawn(io, std::move(operation),
                   [&outcome](const std::exception_ptr& failure, Result<T> result) {
                     if (failure) std::rethrow_exception(failure);
                     outcome = std::move(result);
                   });
  }

  template <typename Condition>
  void run_until(Clock::time_point end, const Condition& is_over) {
    io.restart();
    while (!is_over() && !check_interrupt()) {
      const auto pause = interrupt ? std::min(end, Clock::now() + kInterruptInterval) : end;
      if (io.run_one_until(pause) == 0 && (io.stopped() || Clock::now() >= end)) return;
    }
  }

  bool check_interrupt() {
    if (interrupt && !is_interrupted && Clock::now() >= interrupt_checked + kInterruptInterval) {
      interrupt_checked = Clock::now();
      is_interrupted = interrupt();
    }
    return is_interrupted;
  }

  // Aborts all pending operations.
  void finish() {
    channel.close();
    io.restart();
    io.run();
  }

  // Runs the operation to its end or until the timeout.
  template <typename T>
  Result<T> outcome_of(asio::awaitable<Result<T>> operation, const char* what_it_did_not) {
    std::optional<Result<T>> outcome;
    start(std::move(operation), outcome);
    run_until(std::min(Clock::now() + timeout, deadline), [&] { return outcome.has_value(); });
    if (outcome) return *std::move(outcome);
    finish();
    return silent(what_it_did_not);
  }

  void receive_from_now_on() {
    if (is_receiving || received) return;
    is_receiving = true;
    asio::co_spawn(io, channel.receive(),
                   [this](const std::exception_ptr& failure, Result<std::string> content) {
                     is_receiving = false;
                     if (failure) std::rethrow_exception(failure);
                     received = std::move(content);
                   });
  }

  [[nodiscard]] tl::unexpected<Error> silent(const std::string& what) const {
    if (is_interrupted) return fail(ErrorCode::kCancelled, "The wait was interrupted.");
    if (Clock::now() >= ends_at()) {
      return fail(ErrorCode::kLimitExceeded,
                  "Timed out before " + to_string(channel.server()) + " sent the complete reply.");
    }
    const bool is_stalled = Clock::now() >= stalled_at();
    return fail(
        ErrorCode::kUnavailable,
        to_string(channel.server()) + " " + (is_stalled ? "made no progress" : what) + " within " +
            shortest_text(
                static_cast<double>((is_stalled ? allowed_timeouts * timeout : timeout).count()) /
                1000) +
            " s; set a longer timeout.");
  }
};

MessageSocket::MessageSocket(std::unique_ptr<State> state) : state_(std::move(state)) {}
MessageSocket::MessageSocket(MessageSocket&&) noexcept = default;
MessageSocket& MessageSocket::operator=(MessageSocket&&) noexcept = default;
MessageSocket::~MessageSocket() = default;

Result<MessageSocket> MessageSocket::connect(const Endpoint& server,
                                             std::chrono::milliseconds timeout,
                                             const ChannelOptions& options, Deadline deadline,
                                             Interrupt interrupt) {
  auto state = std::make_unique<State>(server, timeout, options, deadline, std::move(interrupt));
  const auto opened = state->outcome_of(state->channel.open(), "did not accept the connection");
  if (!opened) return tl::unexpected(opened.error());
  return MessageSocket(std::move(state));
}

Result<void> MessageSocket::send(const ClientMessage& message) {
  if (!std::holds_alternative<Ping>(message)) state_->note_progress();
  return state_->outcome_of(state_->channel.send(serialize(message)), "did not accept a message");
}

Result<void> MessageSocket::send_bytes(std::string_view bytes) {
  return state_->outcome_of(state_->channel.send_bytes(std::string(bytes)),
                            "did not accept a message");
}

Result<ServerMessage> MessageSocket::receive(Deadline until) {
  state_->waiting_since = Clock::now();
  state_->wait_ends = until.value_or(Clock::time_point::max());
  Result<std::optional<ServerMessage>> message = std::nullopt;
  while (message && !*message) message = received_within(state_->timeout, kTimeoutsWithoutProgress);
  state_->wait_ends = Clock::time_point::max();
  if (!message) return tl::unexpected(message.error());
  return **std::move(message);
}

Result<std::optional<ServerMessage>> MessageSocket::receive_within(
    std::chrono::milliseconds max_wait) {
  return received_within(max_wait, kTimeoutsWhilePinged);
}

Result<std::optional<ServerMessage>> MessageSocket::received_within(
    std::chrono::milliseconds max_wait, int allowed_timeouts) {
  State& state = *state_;
  state.allowed_timeouts = allowed_timeouts;
  const Clock::time_point until =
      std::min(Clock::now() + max_wait + std::chrono::milliseconds(1), state.ends_at());
  state.receive_from_now_on();
  const auto silent_at = [&state] {
    return std::min(std::max(state.channel.last_activity(), state.waiting_since) + state.timeout,
                    state.stalled_at());
  };
  while (!state.received && !state.is_interrupted && Clock::now() < std::min(until, silent_at())) {
    state.run_until(std::min(until, silent_at()), [&state] { return state.received.has_value(); });
  }
  const bool is_over = state.is_interrupted || Clock::now() >= state.ends_at();
  if (!state.received || is_over) {
    if (Clock::now() < silent_at() && !is_over) return std::nullopt;
    state.finish();
    return state.silent("sent nothing");
  }
  const auto content = *std::exchange(state.received, std::nullopt);
  if (!content) return tl::unexpected(content.error());
  auto message = parse_server_message(*content);
  if (!message) {
    state.finish();
    return tl::unexpected(message.error().error);
  }
  if (!std::holds_alternative<Pong>(*message)) state.note_progress();
  return *std::move(message);
}

}  // namespace multitetra
