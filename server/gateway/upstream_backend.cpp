#include "server/gateway/upstream_backend.hpp"

#include <algorithm>
#include <deque>
#include <iterator>
#include <utility>

#include "common/net/coroutines.hpp"
#include "server/gateway/forwarded_stream.hpp"
#include "server/operations/log.hpp"
#include "server/session/answers.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxWaiting = 4;  // Beyond that nothing is read from a server.

// What a server said, if it is of the kind that answers the question.
std::optional<QuestionReply> reply_to(const Question& question, ServerMessage message) {
  if (std::holds_alternative<Estimate>(question)) {
    if (auto* reply = std::get_if<EstimateReply>(&message)) return *reply;
  } else if (std::holds_alternative<Slice>(question)) {
    if (auto* reply = std::get_if<SliceReply>(&message)) return std::move(*reply);
  } else if (auto* reply = std::get_if<ProbeReply>(&message)) {
    return std::move(*reply);
  }
  return std::nullopt;
}

// A server must have what colours a surface as well. False where none has both.
bool keep_holders_of_scalars(StartStream& action) {
  if (!action.scalars) return true;
  const auto surface = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  const auto field = std::dynamic_pointer_cast<const UpstreamDataset>(action.scalars);
  auto both = std::make_shared<UpstreamDataset>(surface->info());
  std::copy_if(surface->holders.begin(), surface->holders.end(), std::back_inserter(both->holders),
               [&](std::size_t holder) {
                 return std::find(field->holders.begin(), field->holders.end(), holder) !=
                        field->holders.end();
               });
  const bool is_held = !both->holders.empty();
  action.source = std::move(both);
  return is_held;
}

}  // namespace

class UpstreamBackend::Stream : public BackendStream {
 public:
  using Clock = std::chrono::steady_clock;

  Stream(std::weak_ptr<UpstreamBackend> backend, StartStream action, std::function<void()> changed)
      : forwarded(std::move(action.open)),
        dataset(std::dynamic_pointer_cast<const UpstreamDataset>(action.source)),
        changed_(std::move(changed)),
        backend_(std::move(backend)) {}

  std::optional<ServerMessage> take() override {
    if (waiting_.empty()) return std::nullopt;
    ServerMessage message = std::move(waiting_.front());
    waiting_.pop_front();
    if (std::holds_alternative<StepEnd>(message)) ++steps_sent_;
    if (const auto backend = backend_.lock()) backend->change_.notify_all();
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

  // Before anybody was told of it.
  void refuse(Error error) {
    waiting_.push_back(ErrorReply{.request_id = id(), .error = std::move(error)});
    is_finished_ = is_stopped = true;
  }
  // A message of the server; the last one ends the stream behind those that wait.
  void put(ServerMessage message) {
    const bool is_end = is_last(message);
    waiting_.push_back(std::move(message));
    if (is_end) is_stopped = true;
    changed_();
  }
  [[nodiscard]] bool has_room() const { return waiting_.size() < kMaxWaiting; }
  [[nodiscard]] std::uint64_t id() const { return forwarded.open().request_id; }

  ForwardedStream forwarded;
  std::shared_ptr<const UpstreamDataset> dataset;
  bool is_asked = false;  // A server was asked for it, and has not ended it.
  bool is_stopped = false;
  std::optional<Clock::time_point> lost_at = {};  // Its server; none since a message was passed on.

 private:
  // The last message, in the place of what waits.
  void finish(ServerMessage last) {
    if (std::exchange(is_finished_, true)) return;
    waiting_.clear();
    waiting_.push_back(std::move(last));
    stop();
    changed_();
  }
  // Nothing more is wanted of it: the server is told, and ends it. Then its link is free for the
  // next stream.
  void stop() {
    is_stopped = true;
    if (const auto backend = backend_.lock()) backend->cancel(*this);
  }

  bool is_finished_ = false;  // The last message was decided here.
  std::deque<ServerMessage> waiting_;
  std::uint32_t steps_sent_ = 0;
  std::function<void()> changed_;
  std::weak_ptr<UpstreamBackend> backend_;
};

UpstreamBackend::UpstreamBackend(asio::any_io_executor executor,
                                 std::shared_ptr<UpstreamPool> upstreams, ClientContextPtr client)
    : executor_(executor),
      upstreams_(std::move(upstreams)),
      questions_(upstreams_),
      client_(std::move(client)),
      change_(executor) {}
UpstreamBackend::~UpstreamBackend() = default;

std::optional<asio::awaitable<SessionBackend::Found>> UpstreamBackend::find_catalogue(
    std::string token) {
  token_ = token;
  return upstreams_->catalogue(std::move(token));
}

UpstreamClient UpstreamBackend::upstream_client() const {
  constexpr std::size_t kMostOfAName = 256;  // Names of tokens may be long.
  return {.token = token_, .share = client_->share().substr(0, kMostOfAName)};
}

void UpstreamBackend::close() {
  is_closed_ = true;
  if (reached_) reached_->link->close();
  questions_.close();
  change_.notify_all();
}

// ---- streams

BackendStreamPtr UpstreamBackend::start(StartStream action, std::function<void()> changed) {
  const bool is_held = keep_holders_of_scalars(action);
  stream_ = std::make_shared<Stream>(weak_from_this(), std::move(action), std::move(changed));
  const BackendStreamPtr started = stream_;
  if (!is_held) {
    stream_->refuse(
        {ErrorCode::kUnavailable,
         "No server behind this gateway has both the surface's dataset and the one that "
         "shall colour it."});
  }
  change_.notify_all();
  if (!std::exchange(is_bringing_, true)) {
    spawn(executor_, [self = shared_from_this()] { return self->bring_streams(); });
  }
  return started;
}

void UpstreamBackend::cancel(Stream& stream) {
  if (std::exchange(stream.is_asked, false) && reached_) {
    reached_->link->send(Cancel{stream.id()});
  }
  if (stream_.get() == &stream) stream_.reset();
  change_.notify_all();
}

asio::awaitable<void> UpstreamBackend::bring_streams() {
  const auto self = shared_from_this();
  while (!is_closed_) {
    if (const StreamPtr stream = stream_; stream && !stream->is_stopped) {
      co_await bring(stream);
    } else {
      co_await change_.wait();
    }
  }
  if (reached_) reached_->link->close();
}

asio::awaitable<bool> UpstreamBackend::reach_holder(StreamPtr stream) {
  const std::vector<std::size_t> holders = stream->dataset->holders;
  const bool is_there =
      reached_ && !reached_->link->is_lost() &&
      std::find(holders.begin(), holders.end(), reached_->upstream) != holders.end();
  if (is_there) co_return true;
  if (reached_) reached_->link->close();
  reached_.reset();
  std::function<bool()> is_wanted = [this, stream] { return !stream->is_stopped && !is_closed_; };
  UpstreamClient client = upstream_client();  // Not in the awaiting expression: see upstream_pool.
  auto reached = co_await upstreams_->reach(stream->dataset, std::move(client), is_wanted);
  if (!is_wanted()) {
    if (reached) (*reached).link->close();
    co_return false;
  }
  if (reached) {
    reached_ = *std::move(reached);
    co_return true;
  }
  stream->fail(reached.error());
  co_return false;
}

asio::awaitable<void> UpstreamBackend::bring(StreamPtr stream) {
  while (!stream->is_stopped && co_await reach_holder(stream)) {
    // A link that has been idle may have been closed since; that says nothing about its server.
    const bool may_be_stale = std::exchange(reached_->was_used, true);
    stream->forwarded.restart();
    reached_->link->send(stream->forwarded.open());
    stream->is_asked = true;
    if (co_await forward(stream)) co_return;
    stream->is_asked = false;
    if (may_be_stale) continue;
    log_line(LogLevel::kWarning, "a server was lost in a stream; another one is asked",
             {{"connection", client_->facts().connection}, {"request", stream->id()}});
    upstreams_->lost(reached_->upstream);
    const Stream::Clock::time_point now = Stream::Clock::now();
    if (!stream->lost_at) stream->lost_at = now;
    if (now - *stream->lost_at > upstreams_->options().patience) {
      stream->fail({ErrorCode::kUnavailable, "No server brings this stream; try again later."});
    }
  }
}

asio::awaitable<bool> UpstreamBackend::forward(StreamPtr stream) {
  const std::uint64_t id = stream->id();
  const LinkPtr link = reached_->link;
  for (;;) {
    auto message = co_await link->receive();
    if (!message) co_return stream->is_stopped || is_closed_;
    const bool is_end = is_last(*message);
    // A server that stops says so to the connection, and hangs up: as good as lost.
    if (is_end && request_id_of(*message) == 0) {
      link->close();
      co_return stream->is_stopped || is_closed_;
    }
    if (request_id_of(*message) != id) continue;
    if (!stream->is_stopped && is_about_stopping(*message)) {
      link->close();
      co_return false;
    }
    if (is_end) stream->is_asked = false;
    if (!stream->is_stopped) take(stream, *std::move(message));
    if (is_end) co_return true;
    while (!stream->is_stopped && !is_closed_ && !stream->has_room()) co_await change_.wait();
  }
}

void UpstreamBackend::take(const StreamPtr& stream, ServerMessage message) {
  if (is_last(message)) {
    stream->put(std::move(message));
    return;
  }
  switch (stream->forwarded.next(message)) {
    case ForwardedStream::Verdict::kPassOver:
      return;
    case ForwardedStream::Verdict::kDiffers:
      stream->fail({ErrorCode::kUnavailable,
                    "A server was lost, and the one that goes on answers differently; ask again."});
      return;
    case ForwardedStream::Verdict::kForward:
      break;
  }
  stream->lost_at.reset();
  if (const auto* tile = std::get_if<Tile>(&message)) {
    const StepBegin& step = stream->forwarded.step();
    if (step.request.normal_bits == 0 && tile->index < step.tiles.size()) {
      const TileSummary& summary = step.tiles[tile->index];
      upstreams_->tiles().add(
          {.digest = summary.digest, .cube = summary.cube, .dataset = stream->dataset->info().name},
          {.summary = summary, .payload = tile->payload});
    }
  }
  stream->put(std::move(message));
}

// ---- questions

void UpstreamBackend::answer(AnswerQuestion action, std::stop_token,
                             std::function<void(Result<QuestionReply>)> done) {
  spawn(executor_,
        [self = shared_from_this(), action = std::move(action), done = std::move(done)]() mutable {
          return self->bring_answer(std::move(action), std::move(done));
        });
}

asio::awaitable<void> UpstreamBackend::bring_answer(
    AnswerQuestion action, std::function<void(Result<QuestionReply>)> done) {
  const auto self = shared_from_this();
  auto dataset = std::dynamic_pointer_cast<const UpstreamDataset>(action.source);
  UpstreamClient client = upstream_client();
  auto answer = co_await questions_.ask(std::move(dataset), std::move(client), action.question);
  if (!answer) {
    done(tl::unexpected(answer.error()));
  } else if (auto* refusal = std::get_if<ErrorReply>(&*answer)) {
    done(tl::unexpected(refusal->error));
  } else if (auto reply = reply_to(action.question, *std::move(answer))) {
    done(*std::move(reply));
  } else {
    done(fail(ErrorCode::kInternal, std::string("A server answered something else than a ") +
                                        kind_of(action.question) + " asks for."));
  }
}

}  // namespace multitetra
