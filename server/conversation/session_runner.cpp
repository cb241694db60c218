#include "server/conversation/session_runner.hpp"

#include <algorithm>
#include <utility>

#include "common/net/coroutines.hpp"
#include "common/net/frame.hpp"
#include "server/conversation/detail/session_admission.hpp"
#include "server/service/waiting_bytes.hpp"
#include "server/session/answers.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;
using Reservation = ByteReservations::Reservation;

namespace {

// Queued replies, beyond which reading pauses.
constexpr std::size_t kMaxWaitingReplies = 64;

// Returns the dataset of a message; empty if it has none.
std::string requested_dataset(const ClientMessage& message) {
  return std::visit(
      [](const auto& m) -> std::string {
        if constexpr (requires { m.dataset; }) return m.dataset;
        return {};
      },
      message);
}

void end_with(RequestRecord& record, const ServerMessage& last) {
  if (const auto* refusal = std::get_if<ErrorReply>(&last)) {
    record.end(refusal->error);
  } else {
    record.end(outcome_of(last));
  }
}

}  // namespace

SessionRunner::SessionRunner(asio::any_io_executor executor, ServiceClientPtr service_client,
                             Session session, ConnectionContextPtr client,
                             std::chrono::milliseconds idle_time)
    : executor_(executor),
      service_client_(std::move(service_client)),
      session_(std::move(session)),
      client_(std::move(client)),
      idleness_(idle_time, Clock::now()),
      output_available_(executor),
      replies_taken_(executor) {}

// ---- receiving

void SessionRunner::receive(std::string_view content) {
  idleness_.record_activity(Clock::now());
  const auto message = parse_client_message(content);
  const auto* hello = message ? std::get_if<Hello>(&*message) : nullptr;
  if (!hello || session_.is_welcomed() || session_.is_closed() || is_greeting_) {
    take(message, content.size());
    return;
  }
  auto finding = service_client_->find_catalogue(hello->token);
  if (!finding) {
    take(message, content.size());
    return;
  }
  is_greeting_ = true;
  // std::function requires copyable captures, and an awaitable is not copyable.
  auto shared = std::make_shared<asio::awaitable<Result<CataloguePtr>>>(*std::move(finding));
  spawn(executor_, [self = shared_from_this(), hello = *hello, bytes = content.size(), shared] {
    return self->greet(hello, bytes, std::move(*shared));
  });
}

asio::awaitable<void> SessionRunner::greet(Hello hello, std::size_t message_bytes,
                                           asio::awaitable<Result<CataloguePtr>> finding) {
  const auto self = shared_from_this();
  const Result<CataloguePtr> found = co_await std::move(finding);
  is_greeting_ = false;
  if (is_over_) co_return;
  if (found) {
    session_.offer(*found);
    take(ClientMessage(std::move(hello)), message_bytes);
  } else {
    perform(session_.end(found.error()));
  }
  replies_taken_.notify_all();
}

void SessionRunner::take(const tl::expected<ClientMessage, ParseError>& message,
                         std::size_t message_bytes) {
  constexpr std::size_t kLongMessageBytes = 64 * 1024;
  constexpr double kMaxPauseSeconds = 5;
  if (message) hidden_dataset_ = hidden_dataset(*message);
  Received received = receive_from(*client_, session_, message, message_bytes);
  if (received.retry_after > 0 && message_bytes >= kLongMessageBytes) {
    const std::chrono::duration<double> quiet(std::min(received.retry_after, kMaxPauseSeconds));
    paused_until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(quiet);
  }
  request_reservation_ = std::move(received.reservation);
  perform(std::move(received.actions));
  request_reservation_ = {};
  hidden_dataset_.clear();
}

std::string SessionRunner::hidden_dataset(const ClientMessage& message) const {
  std::string dataset = requested_dataset(message);
  if (!session_.is_welcomed() || session_.client_access().rights().may_see(dataset)) return {};
  const CataloguePtr catalogue = service_client_->catalogue();
  return catalogue && catalogue->find(dataset) ? dataset : std::string();
}

void SessionRunner::end(const Error& error) { perform(session_.end(error)); }

void SessionRunner::on_disconnect() {
  is_over_ = true;
  replies_.clear();
  for (auto& [number, query] : queries_) query.stop.request_stop();
  queries_.clear();
  drop_stream();
  leaving_.reset();
  service_client_->close();
  output_available_.notify_all();
  replies_taken_.notify_all();
}

void SessionRunner::enforce_limits(Clock::time_point now) {
  if (is_over_) return;
  if (paused_until_ != Clock::time_point() && now >= paused_until_) {
    paused_until_ = {};
    replies_taken_.notify_all();
  }
  service_client_->enforce_limits(now);
  if (session_.is_closed() || !idleness_.is_exceeded(now, is_busy())) return;
  client_->admission().observer().refused(client_->facts(), "idle_seconds");
  end({ErrorCode::kUnavailable,
       "Idle timeout: no request was received for a long time. Connect again for the next "
       "request."});
}

std::optional<Clock::time_point> SessionRunner::idle_since() const {
  const bool is_idle = !is_busy() && replies_.empty() && !leaving_;
  return is_idle ? std::optional(idleness_.last()) : std::nullopt;
}

// ---- sending

asio::awaitable<std::optional<ServerMessage>> SessionRunner::next_message() {
  const auto self = shared_from_this();
  // The caller has sent the previous message.
  leaving_.reset();
  reply_reservation_ = {};
  for (;;) {
    if (!replies_.empty()) {
      Reply reply = std::move(replies_.front());
      replies_.pop_front();
      reply_reservation_ = std::move(reply.reservation);
      replies_taken_.notify_all();
      co_return std::move(reply.message);
    }
    if (is_over_) co_return std::nullopt;
    if (auto message = next_stream_message()) co_return message;
    co_await output_available_.wait();
  }
}

std::optional<ServerMessage> SessionRunner::next_stream_message() {
  if (!stream_) return std::nullopt;
  auto message = stream_->messages->take();
  if (!message) return std::nullopt;
  if (const auto* tile = std::get_if<Tile>(&*message)) {
    stream_->record->sent_tile(tile->payload->size());
  } else if (std::holds_alternative<StepEnd>(*message)) {
    stream_->record->sent_step();
  } else if (is_last(*message)) {
    end_with(*stream_->record, *message);
    leaving_ = std::move(stream_->record);
    session_.stream_ended(stream_->request_id);
    drop_stream();
  }
  return message;
}

void SessionRunner::report(const ErrorReply& refusal) {
  Error logged = refusal.error;
  if (logged.code == ErrorCode::kUnknownDataset && !hidden_dataset_.empty()) {
    logged.text = "Dataset \"" + hidden_dataset_ + "\" is not allowed for this token.";
  }
  client_->admission().observer().error_answered(client_->facts(), logged, refusal.request_id);
}

void SessionRunner::reject_oversized_reply(const ServerMessage& message) {
  const std::string beyond =
      " has a message longer than " + std::to_string(kMaxServerFrameBytes) + " bytes, the limit";
  if (const auto* list = std::get_if<DatasetList>(&message)) {
    const Error error = {ErrorCode::kLimitExceeded,
                         "The list of datasets" + beyond + "; this server has too many datasets."};
    const ErrorReply refusal{.request_id = list->request_id, .error = error};
    report(refusal);
    replies_.push_front({refusal});
  } else if (stream_) {
    stream_->messages->fail(
        {ErrorCode::kLimitExceeded, "The reply" + beyond + "; request a larger error."});
  }
}

asio::awaitable<void> SessionRunner::until_readable() {
  const auto self = shared_from_this();
  while (!has_room()) co_await replies_taken_.wait();
}

// Replies are short except lists and slices, which may have megabytes.
bool SessionRunner::has_room() const {
  if (is_over_) return true;
  if (paused_until_ != Clock::time_point()) return false;
  const auto is_large = [](const Reply& reply) {
    return std::holds_alternative<DatasetList>(reply.message) ||
           std::holds_alternative<SliceReply>(reply.message);
  };
  return !is_greeting_ && replies_.size() < kMaxWaitingReplies &&
         std::none_of(replies_.begin(), replies_.end(), is_large);
}

void SessionRunner::reply(ServerMessage message, Reservation reservation) {
  replies_.push_back({std::move(message), std::move(reservation)});
  output_available_.notify_all();
}

// ---- actions

void SessionRunner::perform(Actions actions) {
  for (Action& action : actions) {
    std::visit([this](auto& a) { perform(std::move(a)); }, action);
  }
  output_available_.notify_all();
}

void SessionRunner::perform(Send action) {
  auto reservation = client_->reserve(waiting_bytes(action.message));
  if (const auto* list = std::get_if<DatasetList>(&action.message)) {
    RequestRecord record(client_, {.kind = "list", .request = list->request_id});
    if (!reservation) action.message = ErrorReply{list->request_id, reservation.error()};
    reservation ? record.end("complete") : record.end(reservation.error());
  } else if (const auto* refusal = std::get_if<ErrorReply>(&action.message)) {
    report(*refusal);
  }
  replies_.push_back(
      {std::move(action.message), reservation ? *std::move(reservation) : Reservation()});
}

void SessionRunner::perform(ValidatedStream action) {
  const OpenStream& open = action.open;
  const std::string further =
      open.further_datasets.empty()
          ? ""
          : " and " + std::to_string(open.further_datasets.size()) + " more";
  stream_ = {
      .request_id = open.request_id,
      .messages = nullptr,
      .record = std::make_unique<RequestRecord>(
          client_, facts_of("stream", open.request_id, open.dataset + further, open.request)),
      .reservation = std::move(request_reservation_)};
  stream_->messages = service_client_->steps(std::move(action), [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->output_available_.notify_all();
  });
}

void SessionRunner::perform(ValidatedQuery action) {
  const std::uint64_t number = ++last_query_;
  RunningQuery& running = queries_[number];
  running.request_id = request_id_of(action.query);
  running.reservation = std::move(request_reservation_);
  running.record = std::make_unique<RequestRecord>(client_, facts_of(action.query));
  service_client_->answer(std::move(action), running.stop.get_token(), /*use=*/{},
                          [self = shared_from_this(), number](Result<DatasetQueryReply> made) {
                            self->answer_made(number, std::move(made));
                          });
}

void SessionRunner::answer_made(std::uint64_t number, Result<DatasetQueryReply> made) {
  session_.query_ended();
  const auto found = queries_.find(number);
  if (found == queries_.end()) return;
  RunningQuery query = std::move(found->second);
  queries_.erase(found);
  if (is_over_) return;
  idleness_.record_activity(Clock::now());
  made ? query.record->end("complete") : query.record->end(made.error());
  if (made) {
    std::visit([&](auto& answer) { reply(std::move(answer), std::move(query.reservation)); },
               *made);
  } else {
    reply(ErrorReply{.request_id = query.request_id, .error = made.error()});
  }
}

void SessionRunner::perform(StopStream action) {
  if (!stream_) return;
  ServerMessage last;
  if (const auto* error = std::get_if<Error>(&action.outcome)) {
    last = ErrorReply{.request_id = action.request_id, .error = *error};
  } else {
    stream_->messages->end(std::get<StreamOutcome>(action.outcome));
    last = stream_->messages->take().value();
  }
  end_with(*stream_->record, last);
  replies_.push_back({std::move(last)});
  drop_stream();
}

void SessionRunner::perform(Close) {
  is_over_ = true;
  service_client_->close();
}

void SessionRunner::drop_stream() {
  if (!stream_) return;
  stream_->messages->drop();
  stream_.reset();
  idleness_.record_activity(Clock::now());
}

}  // namespace multitetra
