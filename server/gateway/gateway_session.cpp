#include "server/gateway/gateway_session.hpp"

#include <algorithm>
#include <utility>

#include "common/net/frame.hpp"
#include "server/gateway/upstream_answers.hpp"
#include "server/operations/log.hpp"
#include "server/transport/session_admission.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxOutgoing = 64;       // Beyond that nothing is received.
constexpr std::size_t kMaxStreamMessages = 4;  // Beyond that nothing is read from a server.

// Several may wait: none of them may set the time, as that would wake the others.
asio::awaitable<void> wait_on(asio::steady_timer& timer) {
  boost::system::error_code cancelled;
  co_await timer.async_wait(use_error(cancelled));
}

}  // namespace

GatewaySession::GatewaySession(asio::any_io_executor executor,
                               std::shared_ptr<UpstreamPool> gateway, SessionOptions options,
                               ClientContextPtr client, std::chrono::milliseconds idle_time)
    : executor_(executor),
      upstreams_(std::move(gateway)),
      estimates_(upstreams_),
      options_(std::move(options)),
      session_(std::make_shared<const DatasetCatalogue>(), options_, client->admission().access()),
      client_(std::move(client)),
      idleness_(executor, idle_time),
      change_(executor, asio::steady_timer::time_point::max()) {}

void GatewaySession::wake() { change_.cancel(); }

void GatewaySession::say(ServerMessage message, RecordPtr record) {
  outgoing_.push_back({.message = std::move(message), .record = std::move(record)});
  wake();
}

void GatewaySession::receive(std::string_view content) {
  idleness_.note();
  if (!std::exchange(has_heard_, true)) watch_idleness();
  const auto message = parse_client_message(content);
  const auto* hello = message ? std::get_if<Hello>(&*message) : nullptr;
  if (hello && !session_.is_welcomed() && !session_.is_closed() && !is_greeting_) {
    is_greeting_ = true;
    asio::co_spawn(
        executor_, [self = shared_from_this(), hello = *hello] { return self->greet(hello); },
        asio::detached);
    return;
  }
  perform(receive_from(*client_, session_, message));
}

// A token that the gateway itself does not know is refused here, and shown to no server.
asio::awaitable<void> GatewaySession::greet(Hello hello) {
  const auto self = shared_from_this();
  token_ = hello.token;
  const AccessListPtr access = client_->admission().access();
  if (access && !access->rights_of(token_)) {
    is_greeting_ = false;
    perform(receive_from(*client_, session_, hello));
    co_return;
  }
  const auto catalogue = co_await upstreams_->catalogue(token_);
  is_greeting_ = false;
  if (is_over_) co_return;
  if (catalogue) {
    session_ = Session(*catalogue, options_, client_->admission().access());
    perform(receive_from(*client_, session_, hello));
  } else {
    perform(session_.end(catalogue.error()));
  }
}

void GatewaySession::watch_idleness() {
  idleness_.start(
      weak_from_this(),
      [](const GatewaySession& one) { return one.running_ || one.estimates_.are_running(); },
      [](GatewaySession& one) {
        one.client_->admission().observer().refused(one.client_->facts(), "idle_seconds");
        one.end({ErrorCode::kUnavailable,
                 "Nothing was asked for a long time; connect again when there is something to "
                 "ask."});
      });
}

void GatewaySession::end(const Error& error) { perform(session_.end(error)); }

void GatewaySession::leave() {
  is_over_ = true;
  outgoing_.clear();
  leaving_.reset();
  if (running_) {
    running_->is_stopped = true;
    running_->record.reset();
  }
  running_.reset();
  close_links();
  idleness_.stop();
  wake();
}

void GatewaySession::close_links() {
  if (reached_) reached_->link->close();
  estimates_.close();
}

void GatewaySession::give_up(const ServerMessage& message) {
  const Error error = {ErrorCode::kLimitExceeded, "The answer has a message longer than " +
                                                      std::to_string(kMaxServerFrameBytes) +
                                                      " bytes, the most that is sent."};
  outgoing_.push_front({.message = ErrorReply{.request_id = request_id_of(message), .error = error},
                        .record = nullptr});
}

// Whoever asks for another message has sent the one before.
asio::awaitable<std::optional<ServerMessage>> GatewaySession::next_message() {
  const auto self = shared_from_this();
  leaving_.reset();
  for (;;) {
    if (!outgoing_.empty()) {
      Outgoing outgoing = std::move(outgoing_.front());
      outgoing_.pop_front();
      wake();
      co_return told(std::move(outgoing));
    }
    if (is_over_) co_return std::nullopt;
    co_await wait_on(change_);
  }
}

ServerMessage GatewaySession::told(Outgoing outgoing) {
  const ServerMessage& message = outgoing.message;
  const auto* error = std::get_if<ErrorReply>(&message);
  if (error) {
    client_->admission().observer().error_answered(client_->facts(), error->error,
                                                   error->request_id);
  }
  if (RequestRecord* const record = outgoing.record.get()) {
    if (const auto* tile = std::get_if<Tile>(&message)) record->sent_tile(tile->payload->size());
    if (std::holds_alternative<StepEnd>(message)) record->sent_step();
    if (std::holds_alternative<EstimateReply>(message)) record->end("complete");
    if (error || std::holds_alternative<StreamEnd>(message)) record->end(outcome_of(message));
    leaving_ = std::move(outgoing.record);
  }
  return std::move(outgoing.message);
}

asio::awaitable<void> GatewaySession::room() {
  const auto self = shared_from_this();
  const auto has_room = [this] {
    return is_over_ || (!is_greeting_ && outgoing_.size() < kMaxOutgoing &&
                        std::none_of(outgoing_.begin(), outgoing_.end(), [](const Outgoing& one) {
                          return std::holds_alternative<DatasetList>(one.message);
                        }));
  };
  while (!has_room()) co_await wait_on(change_);
}

void GatewaySession::perform(Actions actions) {
  for (Action& action : actions) {
    std::visit([this](auto& a) { perform(std::move(a)); }, action);
  }
  wake();
}

void GatewaySession::perform(Send action) {
  if (const auto* list = std::get_if<DatasetList>(&action.message)) {
    RequestRecord(client_, {.kind = "list", .request = list->request_id}).end("complete");
  }
  say(std::move(action.message));
}

void GatewaySession::perform(StartStream action) {
  const OpenStream& open = action.open;
  auto record = std::make_shared<RequestRecord>(
      client_, facts_of("stream", open.request_id, open.dataset, open.request));
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  running_ = std::make_shared<Running>(Running{.stream = ForwardedStream(std::move(action.open)),
                                               .dataset = std::move(dataset),
                                               .record = std::move(record)});
  if (std::exchange(is_bringing_, true)) return;
  asio::co_spawn(
      executor_, [self = shared_from_this()] { return self->bring_streams(); }, asio::detached);
}

void GatewaySession::perform(MakeEstimate action) {
  asio::co_spawn(
      executor_,
      [self = shared_from_this(), action = std::move(action)] {
        return self->bring_estimate(action);
      },
      asio::detached);
}

// What comes of it from now on is dropped. The server is told, and ends it: then the link is free
// for the next stream.
void GatewaySession::perform(StopStream action) {
  if (!running_) return;
  running_->is_stopped = true;
  if (running_->is_asked && reached_) reached_->link->send(Cancel{action.request_id});
  say(StreamEnd{.request_id = action.request_id,
                .outcome = action.outcome,
                .steps = running_->stream.steps_ended()},
      std::move(running_->record));
  running_.reset();
}

void GatewaySession::perform(Close) {
  is_over_ = true;
  close_links();
}

asio::awaitable<void> GatewaySession::bring_streams() {
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

asio::awaitable<bool> GatewaySession::reach_holder(RunningPtr running) {
  const std::vector<std::size_t> holders = running->dataset->holders;
  const bool is_there =
      reached_ && !reached_->link->is_lost() &&
      std::find(holders.begin(), holders.end(), reached_->upstream) != holders.end();
  if (is_there) co_return true;
  if (reached_) reached_->link->close();
  reached_.reset();
  std::function<bool()> is_wanted = [this, running] { return !running->is_stopped && !is_over_; };
  auto reached = co_await upstreams_->reach(running->dataset, token_, is_wanted);
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

asio::awaitable<void> GatewaySession::bring(RunningPtr running) {
  while (!running->is_stopped && co_await reach_holder(running)) {
    // A link that has been idle may have been closed since; that says nothing about its server.
    const bool may_be_stale = std::exchange(reached_->was_used, true);
    running->stream.restart();
    reached_->link->send(running->stream.open());
    running->is_asked = true;
    if (co_await forward(running)) co_return;
    running->is_asked = false;
    if (may_be_stale) continue;
    log_line(LogLevel::kWarning, "a server was lost in a stream; another one is asked",
             {{"connection", client_->facts().connection},
              {"request", running->stream.open().request_id}});
    upstreams_->lost(reached_->upstream);
    const auto without = std::chrono::steady_clock::now() - running->last_progress;
    if (without > upstreams_->options().patience) {
      finish(running, ErrorReply{.request_id = running->stream.open().request_id,
                                 .error = {ErrorCode::kUnavailable,
                                           "No server brings this stream; try again later."}});
    }
  }
}

asio::awaitable<bool> GatewaySession::forward(RunningPtr running) {
  const std::uint64_t id = running->stream.open().request_id;
  const LinkPtr link = reached_->link;
  for (;;) {
    auto message = co_await link->receive();
    if (!message) co_return running->is_stopped || is_over_;
    const bool is_end = is_last(*message);
    // A server that stops says so to the connection, and hangs up: as good as lost.
    if (is_end && request_id_of(*message) == 0) {
      link->close();
      co_return running->is_stopped || is_over_;
    }
    if (request_id_of(*message) != id) continue;
    if (!running->is_stopped && is_about_stopping(*message)) {
      link->close();
      co_return false;
    }
    if (!running->is_stopped) take(running, *std::move(message));
    if (is_end) co_return true;
    while (!running->is_stopped && !is_over_ && outgoing_.size() >= kMaxStreamMessages) {
      co_await wait_on(change_);
    }
  }
}

void GatewaySession::take(const RunningPtr& running, ServerMessage message) {
  if (is_last(message)) {
    finish(running, std::move(message));
    return;
  }
  switch (running->stream.next(message)) {
    case ForwardedStream::Verdict::kPassOver:
      return;
    case ForwardedStream::Verdict::kDiffers:
      reached_->link->send(Cancel{running->stream.open().request_id});
      finish(running, ErrorReply{.request_id = running->stream.open().request_id,
                                 .error = {ErrorCode::kUnavailable,
                                           "A server was lost, and the one that goes on answers "
                                           "differently; ask again."}});
      return;
    case ForwardedStream::Verdict::kForward:
      break;
  }
  running->last_progress = std::chrono::steady_clock::now();
  if (const auto* tile = std::get_if<Tile>(&message)) {
    const StepBegin& step = running->stream.step();
    if (step.request.normal_bits == 0 && tile->index < step.tiles.size()) {
      const TileSummary& summary = step.tiles[tile->index];
      upstreams_->tiles().add({.digest = summary.digest, .cube = summary.cube},
                              {.summary = summary, .payload = tile->payload});
    }
  }
  say(std::move(message), running->record);
}

void GatewaySession::finish(const RunningPtr& running, ServerMessage last) {
  running->is_stopped = true;
  session_.stream_ended(running->stream.open().request_id);
  if (running_ == running) running_.reset();
  idleness_.note();
  say(std::move(last), std::move(running->record));
}

asio::awaitable<void> GatewaySession::bring_estimate(MakeEstimate action) {
  const auto self = shared_from_this();
  const Estimate& asked = action.estimate;
  const auto record = std::make_shared<RequestRecord>(
      client_, facts_of("estimate", asked.request_id, asked.dataset, asked.request));
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  auto answer = co_await estimates_.ask(std::move(dataset), token_, asked);
  session_.estimate_ended();
  idleness_.note();
  if (is_over_) co_return;
  say(answer ? *std::move(answer)
             : ErrorReply{.request_id = asked.request_id, .error = answer.error()},
      record);
}

}  // namespace multitetra
