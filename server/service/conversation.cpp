#include "server/service/conversation.hpp"

#include <algorithm>
#include <exception>

#include <spdlog/spdlog.h>

#include "server/core/budget.hpp"
#include "server/core/threshold_map.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/service/stream_plan.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;

struct Conversation::RunningStream {
  StreamMessages messages;
  std::shared_ptr<const StepSource> source;
  std::stop_source stop;
  Clock::time_point started = Clock::now();
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
                           const std::stop_token& stop) {
  return guarded(source, "step", stop, [&] { return make_next_step(source, state, stop); });
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

asio::awaitable<void> wait_on(asio::steady_timer& timer) {
  boost::system::error_code cancelled;
  timer.expires_at(Clock::time_point::max());
  co_await timer.async_wait(use_error(cancelled));
}

}  // namespace

Conversation::Conversation(asio::any_io_executor executor, Workers& workers, Session session,
                           std::string peer)
    : executor_(executor),
      workers_(workers),
      client_(workers.new_client()),
      session_(std::move(session)),
      peer_(std::move(peer)),
      something_to_send_(executor),
      replies_taken_(executor) {}

void Conversation::receive(std::string_view content) {
  const auto message = parse_client_message(content);
  perform(message ? session_.receive(*message) : session_.receive(message.error()));
}

void Conversation::end(const Error& error) { perform(session_.end(error)); }

void Conversation::leave() {
  is_over_ = true;
  replies_.clear();
  estimates_stop_.request_stop();
  drop_stream();
  something_to_send_.cancel();
  replies_taken_.cancel();
}

void Conversation::fail_stream(Error error) {
  spdlog::warn("{}: stream {} failed: {}", peer_, stream_->messages.request_id(), error.text);
  stream_->stop.request_stop();
  stream_->messages.fail(std::move(error));
  something_to_send_.cancel();
}

void Conversation::give_up(const ServerMessage& message) {
  const std::string beyond = " has a message longer than " + std::to_string(kMaxServerFrameBytes) +
                             " bytes, the most that is sent";
  if (const auto* list = std::get_if<DatasetList>(&message)) {
    const Error error = {ErrorCode::kLimitExceeded,
                         "The list of datasets" + beyond + "; this server offers too many."};
    spdlog::error("{}: {}", peer_, error.text);
    replies_.push_front(ErrorReply{.request_id = list->request_id, .error = error});
  } else if (stream_) {
    fail_stream({ErrorCode::kLimitExceeded, "The answer" + beyond + "; ask for a larger error."});
  }
}

asio::awaitable<std::optional<ServerMessage>> Conversation::next_message() {
  for (;;) {
    if (!replies_.empty()) {
      ServerMessage reply = std::move(replies_.front());
      replies_.pop_front();
      replies_taken_.cancel();
      co_return reply;
    }
    if (is_over_) co_return std::nullopt;
    if (auto message = take_stream_message()) co_return message;
    co_await wait_on(something_to_send_);
  }
}

asio::awaitable<void> Conversation::room() {
  while (!has_room()) co_await wait_on(replies_taken_);
}

// All replies are short but one: a list may have megabytes.
bool Conversation::has_room() const {
  const auto is_list = [](const ServerMessage& m) {
    return std::holds_alternative<DatasetList>(m);
  };
  return replies_.size() < kMaxWaitingReplies &&
         std::none_of(replies_.begin(), replies_.end(), is_list);
}

void Conversation::perform(Actions actions) {
  for (Action& action : actions) {
    std::visit([this](auto& a) { perform(std::move(a)); }, action);
  }
  something_to_send_.cancel();
}

void Conversation::perform(Send action) { replies_.push_back(std::move(action.message)); }

void Conversation::perform(StartStream action) {
  const IsosurfaceRequest& request = action.open.request;
  spdlog::info("{}: stream {} of {}: isovalue {}, error {} {}, {} tiles held", peer_,
               action.open.request_id, action.open.dataset, request.isovalue, request.error,
               name(request.unit), action.open.held.size());
  stream_ = std::make_shared<RunningStream>(
      RunningStream{.messages = StreamMessages(action.open, action.source->info()),
                    .source = std::move(action.source),
                    .stop = {}});
  make_next_step();
}

void Conversation::perform(MakeEstimate action) {
  // To find what a budget allows takes as long as some steps; without one it is quick.
  const bool is_long = has_budget(action.estimate.request);
  auto make = [self = shared_from_this(), action = std::move(action),
               stop = estimates_stop_.get_token(), guard = asio::make_work_guard(executor_)] {
    auto made = make_estimate(*action.source, action.estimate, stop);
    asio::post(self->executor_, [self, id = action.estimate.request_id, made = std::move(made)] {
      self->session_.estimate_ended();
      if (self->is_over_) return;
      if (made) {
        self->replies_.push_back(*made);
      } else {
        self->replies_.push_back(ErrorReply{.request_id = id, .error = made.error()});
      }
      self->something_to_send_.cancel();
    });
  };
  workers_.post(client_, {.run = std::move(make), .is_long = is_long});
}

void Conversation::perform(StopStream action) {
  if (!stream_) return;
  stream_->messages.end(action.outcome);
  replies_.push_back(stream_->messages.take());
  spdlog::info("{}: stream {} stopped after {:.3f} s", peer_, action.request_id,
               seconds_since(stream_->started));
  drop_stream();
}

void Conversation::perform(Close action) {
  spdlog::info("{}: ending the connection: {}", peer_, action.reason);
  is_over_ = true;
}

void Conversation::make_next_step() {
  if (is_making_ || !stream_) return;
  const auto state = stream_->messages.wanted();
  if (!state) return;
  // The guard keeps the executor running until the step has come back.
  auto make = [self = shared_from_this(), stream = stream_, state = *state,
               guard = asio::make_work_guard(executor_)] {
    const Clock::time_point start = Clock::now();
    auto made = make_step(*stream->source, state, stream->stop.get_token());
    asio::post(self->executor_,
               [self, stream, made = std::move(made), seconds = seconds_since(start)]() mutable {
                 self->step_made(stream, std::move(made), seconds);
               });
  };
  // A first preview is short; what follows may take as long as the whole.
  const bool is_long = !state->previews || !state->shown.empty();
  workers_.post(client_, {.run = std::move(make), .is_long = is_long});
  is_making_ = true;
}

void Conversation::step_made(const std::shared_ptr<RunningStream>& stream, Result<MadeStep> step,
                             double seconds) {
  is_making_ = false;
  if (stream != stream_) {  // It was stopped; the stream after it, if any, has waited.
    make_next_step();
    return;
  }
  if (!step) {
    fail_stream(step.error());
    return;
  }
  stream_->messages.supply(*std::move(step), seconds);
  something_to_send_.cancel();
}

std::optional<ServerMessage> Conversation::take_stream_message() {
  if (!stream_ || !stream_->messages.has_message()) return std::nullopt;
  ServerMessage message = stream_->messages.take();
  if (const auto* step = std::get_if<StepEnd>(&message)) {
    spdlog::info("{}: stream {} step {}: {} tiles, {} bytes, made in {:.3f} s", peer_,
                 step->request_id, step->step, step->tiles_sent, step->payload_bytes,
                 step->seconds);
  }
  if (stream_->messages.is_finished()) {
    spdlog::info("{}: stream {} ended after {:.3f} s", peer_, stream_->messages.request_id(),
                 seconds_since(stream_->started));
    session_.stream_ended(stream_->messages.request_id());
    drop_stream();
  } else {
    make_next_step();
  }
  return message;
}

void Conversation::drop_stream() {
  if (!stream_) return;
  stream_->stop.request_stop();
  stream_.reset();
}

}  // namespace multitetra
