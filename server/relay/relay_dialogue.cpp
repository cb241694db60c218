#include "server/relay/relay_dialogue.hpp"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/frame.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxOutgoing = 64;       // Beyond that nothing is received.
constexpr std::size_t kMaxStreamMessages = 4;  // Beyond that nothing is read from a server.

std::uint64_t request_id_of(const ServerMessage& message) {
  return std::visit(
      [](const auto& m) -> std::uint64_t {
        if constexpr (requires { m.request_id; }) {
          return m.request_id;
        } else {
          return 0;
        }
      },
      message);
}

// The id of a message that counts as a request.
std::optional<std::uint64_t> counted_request(const ClientMessage& message) {
  if (const auto* open = std::get_if<OpenStream>(&message)) return open->request_id;
  if (const auto* estimate = std::get_if<Estimate>(&message)) return estimate->request_id;
  if (const auto* list = std::get_if<ListDatasets>(&message)) return list->request_id;
  return std::nullopt;
}

// Nobody asked for an end: the server is going away, and takes nothing new.
bool is_about_stopping(const ServerMessage& message) {
  if (const auto* end = std::get_if<StreamEnd>(&message)) {
    return end->outcome != StreamOutcome::kComplete;
  }
  const auto* error = std::get_if<ErrorReply>(&message);
  return error && error->error.code == ErrorCode::kUnavailable;
}

// Several may wait: none of them may set the time, as that would wake the others.
asio::awaitable<void> wait_on(asio::steady_timer& timer) {
  boost::system::error_code cancelled;
  co_await timer.async_wait(use_error(cancelled));
}

}  // namespace

RelayDialogue::RelayDialogue(asio::any_io_executor executor, std::shared_ptr<Relay> relay,
                             SessionOptions options, GuestPtr guest)
    : executor_(executor),
      relay_(std::move(relay)),
      options_(std::move(options)),
      session_(std::make_shared<const DatasetCatalogue>(), options_),
      guest_(std::move(guest)),
      change_(executor, asio::steady_timer::time_point::max()) {}

void RelayDialogue::wake() { change_.cancel(); }

void RelayDialogue::say(ServerMessage message) {
  outgoing_.push_back(std::move(message));
  wake();
}

void RelayDialogue::receive(std::string_view content) {
  const auto message = parse_client_message(content);
  const auto* hello = message ? std::get_if<Hello>(&*message) : nullptr;
  if (hello && !session_.is_welcomed() && !session_.is_closed() && !is_greeting_) {
    is_greeting_ = true;
    asio::co_spawn(
        executor_, [self = shared_from_this(), hello = *hello] { return self->greet(hello); },
        asio::detached);
    return;
  }
  const auto counted = message ? counted_request(*message) : std::nullopt;
  if (counted && session_.is_welcomed() && !session_.is_closed()) {
    if (auto error = guest_->may_ask()) {
      say(ErrorReply{.request_id = *counted, .error = *std::move(error)});
      return;
    }
  }
  perform(message ? session_.receive(*message) : session_.receive(message.error()));
}

asio::awaitable<void> RelayDialogue::greet(Hello hello) {
  const auto self = shared_from_this();
  token_ = hello.token;
  const auto catalogue = co_await relay_->catalogue(token_);
  is_greeting_ = false;
  if (is_over_) co_return;
  if (catalogue) {
    session_ = Session(*catalogue, options_);
    perform(session_.receive(hello));
  } else {
    perform(session_.end(catalogue.error()));
  }
}

void RelayDialogue::end(const Error& error) { perform(session_.end(error)); }

void RelayDialogue::leave() {
  is_over_ = true;
  outgoing_.clear();
  if (running_) running_->is_stopped = true;
  running_.reset();
  if (reached_) reached_->link->close();
  wake();
}

void RelayDialogue::give_up(const ServerMessage& message) {
  const Error error = {ErrorCode::kLimitExceeded, "The answer has a message longer than " +
                                                      std::to_string(kMaxServerFrameBytes) +
                                                      " bytes, the most that is sent."};
  outgoing_.push_front(ErrorReply{.request_id = request_id_of(message), .error = error});
}

asio::awaitable<std::optional<ServerMessage>> RelayDialogue::next_message() {
  const auto self = shared_from_this();
  for (;;) {
    if (!outgoing_.empty()) {
      ServerMessage message = std::move(outgoing_.front());
      outgoing_.pop_front();
      wake();
      co_return message;
    }
    if (is_over_) co_return std::nullopt;
    co_await wait_on(change_);
  }
}

asio::awaitable<void> RelayDialogue::room() {
  const auto self = shared_from_this();
  const auto has_room = [this] {
    return is_over_ || (!is_greeting_ && outgoing_.size() < kMaxOutgoing &&
                        std::none_of(outgoing_.begin(), outgoing_.end(), [](const auto& m) {
                          return std::holds_alternative<DatasetList>(m);
                        }));
  };
  while (!has_room()) co_await wait_on(change_);
}

void RelayDialogue::perform(Actions actions) {
  for (Action& action : actions) {
    std::visit([this](auto& a) { perform(std::move(a)); }, action);
  }
  wake();
}

void RelayDialogue::perform(Send action) { say(std::move(action.message)); }

void RelayDialogue::perform(StartStream action) {
  spdlog::info("{}: stream {} of {}: isovalue {}, error {}", peer(), action.open.request_id,
               action.open.dataset, action.open.request.isovalue, action.open.request.error);
  auto dataset = std::dynamic_pointer_cast<const RelayedDataset>(action.source);
  running_ = std::make_shared<Running>(
      Running{.stream = RelayedStream(std::move(action.open)), .dataset = std::move(dataset)});
  if (std::exchange(is_bringing_, true)) return;
  asio::co_spawn(
      executor_, [self = shared_from_this()] { return self->bring_streams(); }, asio::detached);
}

void RelayDialogue::perform(MakeEstimate action) {
  asio::co_spawn(
      executor_,
      [self = shared_from_this(), action = std::move(action)] {
        return self->bring_estimate(action);
      },
      asio::detached);
}

// What comes of it from now on is dropped. The server is told, and ends it: then the link is free
// for the next stream.
void RelayDialogue::perform(StopStream action) {
  if (!running_) return;
  running_->is_stopped = true;
  if (reached_) reached_->link->send(Cancel{action.request_id});
  say(StreamEnd{.request_id = action.request_id,
                .outcome = action.outcome,
                .steps = running_->stream.steps_ended()});
  running_.reset();
}

void RelayDialogue::perform(Close action) {
  spdlog::info("{}: ending the connection: {}", peer(), action.reason);
  is_over_ = true;
  if (reached_) reached_->link->close();
}

asio::awaitable<void> RelayDialogue::bring_streams() {
  const auto self = shared_from_this();
  while (!is_over_) {
    if (const RunningPtr running = running_; running && !running->is_stopped) {
      co_await bring(running);
    } else {
      co_await wait_on(change_);
    }
  }
  if (reached_) reached_->link->close();
}

asio::awaitable<bool> RelayDialogue::reach_holder(RunningPtr running) {
  const std::vector<std::size_t> holders = running->dataset->holders;
  const bool is_there =
      reached_ && !reached_->link->is_lost() &&
      std::find(holders.begin(), holders.end(), reached_->upstream) != holders.end();
  if (is_there) co_return true;
  if (reached_) reached_->link->close();
  reached_.reset();
  std::function<bool()> is_wanted = [this, running] { return !running->is_stopped && !is_over_; };
  auto reached = co_await relay_->reach(holders, token_, is_wanted);
  if (!is_wanted()) {
    if (reached) reached->link->close();
    co_return false;
  }
  if (reached) {
    reached_ = *std::move(reached);
    co_return true;
  }
  finish(running,
         ErrorReply{.request_id = running->stream.open().request_id, .error = reached.error()});
  co_return false;
}

asio::awaitable<void> RelayDialogue::bring(RunningPtr running) {
  while (!running->is_stopped && co_await reach_holder(running)) {
    running->stream.restart();
    reached_->link->send(running->stream.open());
    if (co_await forward(running)) co_return;
    spdlog::warn("{}: a server was lost in stream {}; another one is asked", peer(),
                 running->stream.open().request_id);
    relay_->lost(reached_->upstream);
    const auto without = std::chrono::steady_clock::now() - running->last_progress;
    if (without > relay_->options().patience) {
      finish(running, ErrorReply{.request_id = running->stream.open().request_id,
                                 .error = {ErrorCode::kUnavailable,
                                           "No server brings this stream; try again later."}});
    }
  }
}

asio::awaitable<bool> RelayDialogue::forward(RunningPtr running) {
  const std::uint64_t id = running->stream.open().request_id;
  const LinkPtr link = reached_->link;
  for (;;) {
    auto message = co_await link->receive();
    if (!message) co_return running->is_stopped || is_over_;
    const bool is_last =
        std::holds_alternative<StreamEnd>(*message) || std::holds_alternative<ErrorReply>(*message);
    // A server that stops says so to the connection, and hangs up: as good as lost.
    if (is_last && request_id_of(*message) == 0) {
      link->close();
      co_return running->is_stopped || is_over_;
    }
    if (request_id_of(*message) != id) continue;
    if (!running->is_stopped && is_about_stopping(*message)) {
      link->close();
      co_return false;
    }
    if (!running->is_stopped) take(running, *std::move(message));
    if (is_last) co_return true;
    while (!running->is_stopped && !is_over_ && outgoing_.size() >= kMaxStreamMessages) {
      co_await wait_on(change_);
    }
  }
}

void RelayDialogue::take(const RunningPtr& running, ServerMessage message) {
  if (std::holds_alternative<StreamEnd>(message) || std::holds_alternative<ErrorReply>(message)) {
    finish(running, std::move(message));
    return;
  }
  switch (running->stream.next(message)) {
    case RelayedStream::Verdict::kPassOver:
      return;
    case RelayedStream::Verdict::kDiffers:
      reached_->link->send(Cancel{running->stream.open().request_id});
      finish(running, ErrorReply{.request_id = running->stream.open().request_id,
                                 .error = {ErrorCode::kUnavailable,
                                           "A server was lost, and the one that goes on answers "
                                           "differently; ask again."}});
      return;
    case RelayedStream::Verdict::kForward:
      break;
  }
  running->last_progress = std::chrono::steady_clock::now();
  if (const auto* tile = std::get_if<Tile>(&message)) {
    const StepBegin& step = running->stream.step();
    if (step.request.normal_bits == 0 && tile->index < step.tiles.size()) {
      const TileSummary& summary = step.tiles[tile->index];
      relay_->tiles().add({.digest = summary.digest, .cube = summary.cube},
                          {.summary = summary, .payload = tile->payload});
    }
  }
  say(std::move(message));
}

void RelayDialogue::finish(const RunningPtr& running, ServerMessage last) {
  running->is_stopped = true;
  session_.stream_ended(running->stream.open().request_id);
  if (running_ == running) running_.reset();
  say(std::move(last));
}

asio::awaitable<void> RelayDialogue::bring_estimate(MakeEstimate action) {
  const auto self = shared_from_this();
  const auto dataset = std::dynamic_pointer_cast<const RelayedDataset>(action.source);
  Result<ServerMessage> answer = fail(ErrorCode::kUnavailable, "");
  for (int attempt = 0; attempt < 3 && !answer && !is_over_; ++attempt) {
    std::function<bool()> is_wanted = [this] { return !is_over_; };
    const auto reached = co_await relay_->reach(dataset->holders, token_, is_wanted);
    if (!reached) {
      answer = tl::unexpected(reached.error());
      break;
    }
    reached->link->send(action.estimate);
    answer = co_await reached->link->receive();
    reached->link->close();
    if (!answer) relay_->lost(reached->upstream);
  }
  session_.estimate_ended();
  if (is_over_) co_return;
  say(answer ? *std::move(answer)
             : ErrorReply{.request_id = action.estimate.request_id, .error = answer.error()});
}

}  // namespace multitetra
