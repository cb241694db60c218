#include "server/transport/stream_session.hpp"

#include <algorithm>
#include <exception>

#include <spdlog/spdlog.h>

#include "common/base/number_text.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/thresholds/threshold_map.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/stream/stream_plan.hpp"
#include "server/transport/session_admission.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;

// Workers hold it as well; they touch only what makes the step.
struct StreamSession::RunningStream {
  StreamMessages messages;
  std::shared_ptr<const StepSource> source;
  std::unique_ptr<RequestRecord> record;
  std::stop_source stop = {};
  double worker_seconds = 0;                             // Of the steps that were made.
  ByteReservations::Reservation queue_reservation = {};  // Of the step that is being sent.
};

struct StreamSession::RunningEstimate {
  Estimate asked;
  std::shared_ptr<const StepSource> source;
  std::unique_ptr<RequestRecord> record;
  asio::steady_timer timer;
  std::stop_source stop = {};
};

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Runs on a worker. The client learns that something went wrong here; the log says what.
template <typename Make>
auto guarded(const StepSource& source, const char* what, const std::stop_token& stop,
             const Make& make) -> Result<decltype(make())> {
  try {
    if (stop.stop_requested()) throw Cancelled{};
    return make();
  } catch (const Cancelled&) {
    return fail(ErrorCode::kCancelled, std::string("The ") + what + " was cancelled.");
  } catch (const BudgetTooSmall& problem) {
    return fail(ErrorCode::kLimitExceeded, problem.what());
  } catch (const StepTooLarge& problem) {
    return fail(ErrorCode::kLimitExceeded, problem.what());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kLimitExceeded,
                std::string("The server has not enough memory for this ") + what +
                    "; ask for a larger error.");
  } catch (const DatasetFileError& damage) {
    spdlog::error("dataset {}: {}", source.info().name, damage.what());
    return fail(ErrorCode::kDamagedData, std::string("The dataset's file is damaged where this ") +
                                             what + " needs it; the server's log says where.");
  } catch (const std::exception& trouble) {
    spdlog::error("dataset {}: making a {} failed: {}", source.info().name, what, trouble.what());
    return fail(ErrorCode::kInternal,
                std::string("The server failed to make this ") + what + "; its log says why.");
  }
}

Result<MadeStep> make_step(const StepSource& source, const StreamState& state,
                           std::uint64_t max_triangles, const std::stop_token& stop) {
  return guarded(source, "step", stop,
                 [&] { return make_next_step(source, state, stop, max_triangles); });
}

// What a client can hold of a number that is only about right.
std::uint64_t rounded(double value) {
  return static_cast<std::uint64_t>(std::min(value, 1e18) + 0.5);
}

Result<EstimateReply> make_estimate(const StepSource& source, const Estimate& asked,
                                    const std::stop_token& stop) {
  return guarded(source, "estimate", stop, [&] {
    const EstimatedAnswer found = estimate(source, asked.request, stop);
    return EstimateReply{.request_id = asked.request_id,
                         .triangles = rounded(found.size.triangles),
                         .bytes = rounded(found.size.bytes),
                         .threshold_world = largest_threshold(found.request, source.info())};
  });
}

Error too_long(std::chrono::milliseconds limit) {
  return {ErrorCode::kLimitExceeded,
          "The answer takes this server longer than the " +
              shortest_text(static_cast<double>(limit.count()) / 1000) +
              " s that it spends on one request; ask for a larger error."};
}

asio::awaitable<void> wait_on(asio::steady_timer& timer) {
  boost::system::error_code cancelled;
  timer.expires_at(Clock::time_point::max());
  co_await timer.async_wait(use_error(cancelled));
}

}  // namespace

StreamSession::StreamSession(asio::any_io_executor executor, Workers& workers, Session session,
                             ClientContextPtr client, SessionLimits limits)
    : executor_(executor),
      workers_(workers),
      queue_client_(workers.new_client()),
      session_(std::move(session)),
      client_(std::move(client)),
      limits_(limits),
      worker_timer_(executor),
      idleness_(executor, limits.idle_time),
      something_to_send_(executor),
      replies_taken_(executor) {}

void StreamSession::receive(std::string_view content) {
  idleness_.note();
  if (!std::exchange(has_heard_, true)) watch_idleness();
  perform(receive_from(*client_, session_, parse_client_message(content)));
}

void StreamSession::watch_idleness() {
  idleness_.start(
      weak_from_this(),
      [](const StreamSession& one) { return one.stream_ || !one.estimates_.empty(); },
      [](StreamSession& one) {
        one.client_->admission().observer().refused(one.client_->facts(), "idle_seconds");
        one.end({ErrorCode::kUnavailable,
                 "Nothing was asked for a long time; connect again when there is something to "
                 "ask."});
      });
}

void StreamSession::end(const Error& error) { perform(session_.end(error)); }

void StreamSession::leave() {
  is_over_ = true;
  replies_.clear();
  for (const auto& estimate : estimates_) {
    estimate->stop.request_stop();
    estimate->timer.cancel();
    estimate->record.reset();
  }
  estimates_.clear();
  drop_stream();
  leaving_.reset();
  idleness_.stop();
  something_to_send_.cancel();
  replies_taken_.cancel();
}

void StreamSession::fail_stream(Error error) {
  stream_->stop.request_stop();
  stream_->messages.fail(std::move(error));
  something_to_send_.cancel();
}

void StreamSession::give_up(const ServerMessage& message) {
  const std::string beyond = " has a message longer than " + std::to_string(kMaxServerFrameBytes) +
                             " bytes, the most that is sent";
  if (const auto* list = std::get_if<DatasetList>(&message)) {
    const Error error = {ErrorCode::kLimitExceeded,
                         "The list of datasets" + beyond + "; this server offers too many."};
    replies_.push_front(ErrorReply{.request_id = list->request_id, .error = error});
  } else if (stream_) {
    fail_stream({ErrorCode::kLimitExceeded, "The answer" + beyond + "; ask for a larger error."});
  }
}

asio::awaitable<std::optional<ServerMessage>> StreamSession::next_message() {
  leaving_.reset();  // Whoever asks for another message has sent the one before.
  for (;;) {
    if (!replies_.empty()) {
      ServerMessage reply = std::move(replies_.front());
      replies_.pop_front();
      replies_taken_.cancel();
      co_return told(std::move(reply));
    }
    if (is_over_) co_return std::nullopt;
    if (auto message = take_stream_message()) co_return message;
    co_await wait_on(something_to_send_);
  }
}

ServerMessage StreamSession::told(ServerMessage message) {
  if (const auto* reply = std::get_if<ErrorReply>(&message)) {
    client_->admission().observer().error_answered(client_->facts(), reply->error,
                                                   reply->request_id);
  }
  return message;
}

asio::awaitable<void> StreamSession::room() {
  while (!has_room()) co_await wait_on(replies_taken_);
}

// All replies are short but one: a list may have megabytes.
bool StreamSession::has_room() const {
  const auto is_list = [](const ServerMessage& m) {
    return std::holds_alternative<DatasetList>(m);
  };
  return replies_.size() < kMaxWaitingReplies &&
         std::none_of(replies_.begin(), replies_.end(), is_list);
}

void StreamSession::perform(Actions actions) {
  for (Action& action : actions) {
    std::visit([this](auto& a) { perform(std::move(a)); }, action);
  }
  something_to_send_.cancel();
}

void StreamSession::perform(Send action) {
  if (const auto* list = std::get_if<DatasetList>(&action.message)) {
    RequestRecord(client_, {.kind = "list", .request = list->request_id}).end("complete");
  }
  replies_.push_back(std::move(action.message));
}

void StreamSession::perform(StartStream action) {
  const OpenStream& open = action.open;
  auto record = std::make_unique<RequestRecord>(
      client_, facts_of("stream", open.request_id, open.dataset, open.request));
  stream_ = std::make_shared<RunningStream>(
      RunningStream{.messages = StreamMessages(open, action.source->info()),
                    .source = std::move(action.source),
                    .record = std::move(record)});
  make_next_step();
}

void StreamSession::perform(MakeEstimate action) {
  // To find what a budget allows takes as long as some steps, and so does simplifying a sample.
  const IsosurfaceRequest& request = action.estimate.request;
  const bool is_long = has_budget(request) || request.simplify;
  const Estimate& asked = action.estimate;
  auto record = std::make_unique<RequestRecord>(
      client_, facts_of("estimate", asked.request_id, asked.dataset, asked.request));
  const auto estimate =
      std::make_shared<RunningEstimate>(RunningEstimate{.asked = std::move(action.estimate),
                                                        .source = std::move(action.source),
                                                        .record = std::move(record),
                                                        .timer = asio::steady_timer(executor_)});
  estimates_.insert(estimate);
  // What belongs to the executor's thread is given back to it, and let go there.
  auto make = [self = shared_from_this(), estimate, stop = estimate->stop.get_token(),
               guard = asio::make_work_guard(executor_)]() mutable {
    const asio::any_io_executor executor = self->executor_;
    asio::post(executor, [self, estimate] { self->watch_worker(estimate); });
    auto made = make_estimate(*estimate->source, estimate->asked, stop);
    asio::post(executor, [self = std::move(self), estimate = std::move(estimate),
                          made = std::move(made)]() mutable {
      self->estimate_made(estimate, std::move(made));
    });
  };
  workers_.post(queue_client_, {.run = std::move(make), .is_long = is_long});
}

void StreamSession::watch_worker(const std::shared_ptr<RunningEstimate>& estimate) {
  if (limits_.request_time.count() <= 0 || !estimates_.contains(estimate)) return;
  estimate->timer.expires_after(limits_.request_time);
  estimate->timer.async_wait(
      [weak = std::weak_ptr(estimate)](const boost::system::error_code& cancelled) {
        const auto running = weak.lock();
        if (!cancelled && running) running->stop.request_stop();
      });
}

void StreamSession::estimate_made(const std::shared_ptr<RunningEstimate>& estimate,
                                  Result<EstimateReply> made) {
  session_.estimate_ended();
  if (estimates_.erase(estimate) == 0) return;  // The client has left.
  estimate->timer.cancel();
  if (is_over_) return;
  idleness_.note();
  if (!made && estimate->stop.stop_requested()) {
    client_->admission().observer().refused(client_->facts(), "request_seconds");
    made = tl::unexpected(too_long(limits_.request_time));
  }
  estimate->record->end(made ? "complete" : name(made.error().code));
  if (made) {
    replies_.push_back(*made);
  } else {
    replies_.push_back(ErrorReply{.request_id = estimate->asked.request_id, .error = made.error()});
  }
  something_to_send_.cancel();
}

void StreamSession::perform(StopStream action) {
  if (!stream_) return;
  stream_->messages.end(action.outcome);
  ServerMessage last = stream_->messages.take();
  stream_->record->end(outcome_of(last));
  replies_.push_back(std::move(last));
  drop_stream();
}

void StreamSession::perform(Close) { is_over_ = true; }

void StreamSession::make_next_step() {
  if (is_making_ || !stream_) return;
  const auto state = stream_->messages.wanted();
  if (!state) return;
  stream_->queue_reservation = {};
  // The guard keeps the executor running until the step has come back. What belongs to the
  // executor's thread is given back to it, and let go there.
  auto make = [self = shared_from_this(), stream = stream_, state = *state,
               most = limits_.max_triangles, guard = asio::make_work_guard(executor_)]() mutable {
    const asio::any_io_executor executor = self->executor_;
    asio::post(executor, [self, stream] { self->watch_worker(stream); });
    const Clock::time_point start = Clock::now();
    auto made = make_step(*stream->source, state, most, stream->stop.get_token());
    asio::post(executor, [self = std::move(self), stream = std::move(stream),
                          made = std::move(made), seconds = seconds_since(start)]() mutable {
      self->step_made(stream, std::move(made), seconds);
    });
  };
  // A first preview is short; what follows may take as long as the whole.
  const bool is_long = !state->previews || !state->shown.empty();
  workers_.post(queue_client_, {.run = std::move(make), .is_long = is_long});
  is_making_ = true;
}

void StreamSession::watch_worker(const std::shared_ptr<RunningStream>& stream) {
  if (limits_.request_time.count() <= 0 || stream != stream_) return;
  const std::chrono::duration<double> left =
      limits_.request_time - std::chrono::duration<double>(stream->worker_seconds);
  worker_timer_.expires_after(std::chrono::duration_cast<Clock::duration>(left));
  worker_timer_.async_wait([weak = weak_from_this(), of = std::weak_ptr(stream)](
                               const boost::system::error_code& cancelled) {
    const auto self = weak.lock();
    const auto late = of.lock();
    if (cancelled || !self || !late || late != self->stream_) return;
    self->client_->admission().observer().refused(self->client_->facts(), "request_seconds");
    self->fail_stream(too_long(self->limits_.request_time));
  });
}

void StreamSession::step_made(const std::shared_ptr<RunningStream>& stream, Result<MadeStep> step,
                              double seconds) {
  is_making_ = false;
  worker_timer_.cancel();
  client_->admission().observer().step_made(seconds);
  if (stream != stream_) {  // It was stopped; the stream after it, if any, has waited.
    make_next_step();
    return;
  }
  stream->worker_seconds += seconds;
  if (!step) {
    fail_stream(step.error());
    return;
  }
  auto share =
      client_->admission().queue().take(static_cast<std::size_t>(size_of(step->encoded).bytes));
  if (!share) {
    client_->admission().observer().refused(client_->facts(), "queue_bytes");
    fail_stream({ErrorCode::kUnavailable,
                 "This server has no room for another step of that size, because others wait for "
                 "slow clients; try again later, or ask for a larger error."});
    return;
  }
  stream->queue_reservation = *std::move(share);
  stream->messages.supply(*std::move(step), seconds);
  something_to_send_.cancel();
}

std::optional<ServerMessage> StreamSession::take_stream_message() {
  if (!stream_ || !stream_->messages.has_message()) return std::nullopt;
  ServerMessage message = stream_->messages.take();
  if (const auto* tile = std::get_if<Tile>(&message)) {
    stream_->record->sent_tile(tile->payload->size());
  } else if (std::holds_alternative<StepEnd>(message)) {
    stream_->record->sent_step();
  }
  if (stream_->messages.is_finished()) {
    stream_->record->end(outcome_of(message));
    leaving_ = std::move(stream_->record);
    session_.stream_ended(stream_->messages.request_id());
    drop_stream();
  } else {
    make_next_step();
  }
  return told(std::move(message));
}

// A worker may hold it still; what it took of others is given back now.
void StreamSession::drop_stream() {
  if (!stream_) return;
  stream_->stop.request_stop();
  stream_->record.reset();
  stream_->queue_reservation = {};
  stream_.reset();
  idleness_.note();
}

}  // namespace multitetra
